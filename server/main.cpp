#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <iostream>
#include <memory>
#include <mutex>

#include "common/security/secret.hpp"
#include "server/map_merge_server.hpp"
#include "server/merge_worker/work_mark.hpp"
#include "server/stop_deadline.hpp"
#include "server/store/backup.hpp"
#include "server/store/migration.hpp"
#include "server/support/printable_log.hpp"

namespace {

using namespace headframe;

constexpr int bad_usage = 2;
constexpr auto stop_within = std::chrono::seconds(4);
constexpr auto database_within = std::chrono::seconds(60);  // at the start: both may just have been switched on

int fail(const std::string& message, int status) {
  std::cerr << "headframe-server: " << message << '\n';
  return status;
}

/// SIGINT and SIGTERM wait for wait_for_signal() from here on, in every thread that is started later.
sigset_t hold_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

/// A robot may have many connections: as many files open as the system allows without asking.
void raise_file_limit() {
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) != 0) return;
  files.rlim_cur = files.rlim_max;
  (void)::setrlimit(RLIMIT_NOFILE, &files);
}

/// What a start waits for: that the database answers, and, when it stands by, that another server lets go of it.
class StartWaits {
 public:
  explicit StartWaits(const sigset_t& signals) : signals_(signals), database_until_(Clock::now() + database_within) {}

  void stand_by(const Endpoint& robots, const Endpoint& http, const std::filesystem::path& data) {
    stands_by_ = true;
    std::cout << "headframe-server stands by: another server has the database; when it falls free, robots on "
              << to_string(robots) << ", http on " << to_string(http) << ", data in " << data.string() << std::endl;
  }

  /// Who stands by waits for the database, too, however long it is away.
  bool for_database(const Error& why, std::chrono::milliseconds pause) {
    if (!stands_by_ || Clock::now() >= say_away_) {
      spdlog::warn("waiting for the database: {}", why.message);
      say_away_ = Clock::now() + say_away_every;
    }
    return passes(pause) && (stands_by_ || Clock::now() < database_until_);
  }

  bool for_turn(const Error& why, std::chrono::milliseconds pause) {
    if (Clock::now() >= say_so_) spdlog::info("stands by: {}", why.message);
    if (Clock::now() >= say_so_) say_so_ = Clock::now() + say_so_every;
    return passes(pause);
  }

  /// A signal ended it while it stood by, which is no fault.
  bool was_sent_home() const { return stands_by_ && signalled_; }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr auto say_so_every = std::chrono::hours(1);
  static constexpr auto say_away_every = std::chrono::minutes(1);  // while it stands by: it looks often

  bool passes(std::chrono::milliseconds pause) {
    const timespec time{pause.count() / 1000, pause.count() % 1000 * 1'000'000};
    signalled_ = signalled_ || sigtimedwait(&signals_, nullptr, &time) > 0;
    return !signalled_;
  }

  const sigset_t signals_;
  const Clock::time_point database_until_;
  Clock::time_point say_so_ = {}, say_away_ = {};
  bool stands_by_ = false, signalled_ = false;
};

/// Why the server ends, where that is no signal from outside.
class TakenOver {
 public:
  void say(const Error& why) {
    {
      const std::lock_guard lock(mutex_);
      why_ = why.message;
    }
    ::kill(::getpid(), SIGTERM);  // the main thread waits for one
  }
  std::string why() {
    const std::lock_guard lock(mutex_);
    return why_;
  }

 private:
  std::mutex mutex_;
  std::string why_;
};

int serve(ServerOptions options) {
  const sigset_t signals = hold_signals();
  StartWaits waits(signals);
  TakenOver taken_over;
  options.wait_for_database = [&](const Error& why, auto pause) { return waits.for_database(why, pause); };
  options.wait_for_turn = [&](const Error& why, auto pause) { return waits.for_turn(why, pause); };
  options.on_standby = [&](const Endpoint& robots, const Endpoint& http) {
    waits.stand_by(robots, http, options.data);
  };
  options.on_taken_over = [&](const Error& why) { taken_over.say(why); };
  auto server = MapMergeServer::start(options);
  if (!server && waits.was_sent_home()) return 0;
  if (!server) return fail(server.error().message, 1);
  if (!options.insecure) std::cout << "headframe-server fingerprint: " << to_hex((*server)->fingerprint()) << '\n';
  if (!options.insecure && !(*server)->https() && !is_loopback(options.http))
    spdlog::warn("the operator API on {} is not encrypted: who listens on the way learns the operator's token",
                 to_string((*server)->http()));
  const std::string page = ((*server)->https() ? "https://" : "http://") + to_string((*server)->http()) + "/";
  std::cout << "operators: " << page
            << (options.insecure ? std::string(", without a token")
                                 : ", with the token in " + (options.data / "operator.token").string())
            << '\n';
  std::cout << "headframe-server ready: robots on " << to_string((*server)->robots()) << ", http on "
            << to_string((*server)->http()) << ", data in " << options.data.string() << std::endl;
  int signal = 0;
  sigwait(&signals, &signal);
  const std::string why = taken_over.why();
  if (why.empty()) spdlog::info("signal {}: finishing", signal);
  const StopDeadline deadline(stop_within, why.empty() ? 0 : 1);
  if (!why.empty()) (void)fail(why, 1);
  server->reset();
  return why.empty() ? 0 : 1;
}

int restore(const std::string& backup, const std::string& data) {
  if (auto restored = restore_backup(backup, data); !restored) return fail("--restore: " + restored.error().message, 1);
  std::cout << "headframe-server: " << data << " is as it was when " << backup
            << " was written; robots send again what they still have of the time since\n";
  return 0;
}

/// Now and then a line: how far a table is.
TableProgress printed_progress() {
  static constexpr auto often_enough = std::chrono::seconds(2);
  auto last = std::make_shared<std::chrono::steady_clock::time_point>();
  return [last](std::string_view table, std::uint64_t rows, std::uint64_t of) {
    const auto now = std::chrono::steady_clock::now();
    if (rows != 0 && (rows == of || now - *last < often_enough)) return;
    *last = now;
    if (of > 0) std::cout << table << ": " << rows << " of " << of << std::endl;
  };
}

int migrate_store(const std::string& from, const std::string& to) {
  constexpr std::string_view sqlite = "sqlite:", postgres = "postgres";
  const bool forth = from.starts_with(sqlite) && to.starts_with(postgres);
  if (!forth && !(from.starts_with(postgres) && to.starts_with(sqlite)))
    return fail("--migrate takes sqlite:DIR and postgresql://..., in the order from and to", bad_usage);
  const auto done = forth ? migrate_to_postgres(from.substr(sqlite.size()), to, printed_progress())
                          : migrate_to_sqlite(from, to.substr(sqlite.size()), printed_progress());
  if (!done) return fail("--migrate: " + done.error().message, 1);
  std::cout << "headframe-server: " << done->tables << " tables with " << done->rows
            << " rows were copied, read again and found the same; "
            << (forth ? "give the url in [store] from now on" : "leave the url in [store] away from now on") << '\n';
  return 0;
}

int run(int argc, char** argv) {
  std::vector<std::string> from_to;
  std::string data, listen = "127.0.0.1:7447", http = "127.0.0.1:7448", config, backup;
  bool insecure = false, insecure_any = false, new_identity = false;
  CLI::App app("The base station: robots stream their maps, the server merges them.", "headframe-server");
  app.add_option("--data", data, "directory of the database; made when it is not there");
  app.add_option("--listen", listen, "HOST:PORT for robots; port 0 takes any")->capture_default_str();
  app.add_option("--http", http, "HOST:PORT for operators; port 0 takes any")->capture_default_str();
  app.add_flag("--insecure", insecure, "on the loopback: no TLS, no enrolment, no operator's token");
  app.add_flag("--insecure-any", insecure_any, "the same on any address: who reaches the ports may do anything");
  app.add_flag("--new-identity", new_identity,
               "make another key where the server's own is lost: all robots enrol anew");
  app.add_option("--restore", backup, "make --data from this file, which headframe backup has written, and end");
  app.add_option("--migrate", from_to, "take all from sqlite:DIR to a postgresql:// URL, or back, and end")
      ->expected(2);
  app.add_option("--config", config, "TOML file: [server], [store], [operator], [limits], [merge]");
  app.set_version_flag("--version", "headframe-server " HEADFRAME_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : bad_usage;
  }
  if (!from_to.empty()) return migrate_store(from_to[0], from_to[1]);
  if (data.empty()) return fail("--data is required: the directory of the database", bad_usage);
  if (!backup.empty()) return restore(backup, data);
  const auto robots = parse_endpoint(listen), operators = parse_endpoint(http);
  if (!robots) return fail("--listen: " + robots.error().message, bad_usage);
  if (!operators) return fail("--http: " + operators.error().message, bad_usage);
  for (const auto& endpoint : {*robots, *operators})
    if (insecure && !insecure_any && !is_loopback(endpoint))
      return fail("--insecure serves the loopback only, and " + to_string(endpoint) +
                      " is not of it: leave --insecure away and enrol the robots, or give --insecure-any",
                  bad_usage);
  auto settings = config.empty() ? Result<ServerConfig>(ServerConfig()) : load_config(config);
  if (!settings) return fail(settings.error().message, bad_usage);
  return serve({data, *robots, *operators, *settings, insecure || insecure_any, new_identity});
}

}  // namespace

int main(int argc, char** argv) {
  raise_file_limit();
  WorkMark::watch_for_faults();
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // a file at its limit is a full disk, which is waited out
  spdlog::set_default_logger(spdlog::stderr_color_mt("headframe"));
  spdlog::set_formatter(printable_log());
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    return fail(error.what(), 1);
  }
}
