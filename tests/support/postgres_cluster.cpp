#include "tests/support/postgres_cluster.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <libpq-fe.h>
#include <pwd.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <thread>

namespace headframe::test {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

namespace {

constexpr const char* superuser = "headframe";
constexpr std::string_view folder_prefix = "headframe-pg-";
constexpr const char* lock_name = "lock";

/// PostgreSQL does not run as root.
const passwd* unprivileged() {
  const passwd* postgres = ::getpwnam("postgres");
  return postgres != nullptr ? postgres : ::getpwnam("nobody");
}

/// Files in memory outlive killed processes as those on a disk do, and cost nobody's disk anything; where there is
/// little memory for them (a container has 64 MB), the temporary folder.
fs::path roomy_memory() {
  constexpr std::uintmax_t enough_bytes = 1ULL << 30U;
  std::error_code none;
  const fs::path memory = "/dev/shm";
  const auto space = fs::space(memory, none);
  return !none && space.available >= enough_bytes ? memory : fs::temp_directory_path();
}

/// What clusters left whose tests were killed: they ended, but nobody was there to remove their folders. The lock of
/// one that is there ended with its test.
void remove_what_was_left(const fs::path& place) {
  std::error_code none;
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(place, none)) {
    if (!entry.path().filename().string().starts_with(folder_prefix)) continue;
    const int lock = ::open((entry.path() / lock_name).c_str(), O_RDWR | O_CLOEXEC);
    if (lock < 0) continue;
    if (::flock(lock, LOCK_EX | LOCK_NB) == 0) left.push_back(entry.path());
    ::close(lock);
  }
  for (const fs::path& folder : left) fs::remove_all(folder, none);
}

std::vector<int> children_of(int parent) {
  std::vector<int> children;
  std::ifstream in("/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent) + "/children");
  for (int child = 0; in >> child;) children.push_back(child);
  return children;
}

}  // namespace

fs::path PostgresCluster::programs() {
  std::error_code none;
  std::vector<fs::path> found;
  for (const auto& version : fs::directory_iterator("/usr/lib/postgresql", none))
    if (fs::exists(version.path() / "bin" / "initdb")) found.push_back(version.path() / "bin");
  return found.empty() ? fs::path() : *std::max_element(found.begin(), found.end());
}

std::vector<std::string> PostgresCluster::as_unprivileged(const std::string& program) const {
  std::vector<std::string> argv{"/usr/bin/setpriv", "--pdeathsig", "QUIT"};
  if (::geteuid() == 0)
    argv.insert(argv.end(), {"--reuid", unprivileged()->pw_name, "--regid", std::to_string(unprivileged()->pw_gid),
                             "--clear-groups"});
  argv.push_back((programs() / program).string());
  return argv;
}

Result<std::unique_ptr<PostgresCluster>> PostgresCluster::make(const fs::path& place) {
  const fs::path parent = place.empty() ? roomy_memory() : place;
  remove_what_was_left(parent);
  std::string making = (parent / "headframe-new-XXXXXX").string();
  if (::mkdtemp(making.data()) == nullptr) return failure(ErrorCode::unavailable, "no temporary folder " + making);
  const std::string name = (parent / (std::string(folder_prefix) + making.substr(making.size() - 6))).string();
  std::unique_ptr<PostgresCluster> made(new PostgresCluster(name));
  made->lock_ = ::open((making + "/" + lock_name).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  const bool locked = made->lock_ >= 0 && ::flock(made->lock_, LOCK_EX | LOCK_NB) == 0;
  if (!locked || std::rename(making.c_str(), name.c_str()) != 0)  // under its name nobody finds it free
    return failure(ErrorCode::unavailable, making + " can not be locked and renamed");
  if (::geteuid() == 0 && ::chown(name.c_str(), unprivileged()->pw_uid, unprivileged()->pw_gid) != 0)
    return failure(ErrorCode::unavailable, name + " can not be given away");
  auto argv = made->as_unprivileged("initdb");
  argv.insert(argv.end(), {"-D", name + "/data", "-U", superuser, "-A", "trust", "-E", "UTF8", "--locale=C",
                           "--no-sync", "--no-instructions"});
  auto initdb = Process::start(argv);
  if (!initdb) return tl::unexpected(initdb.error());
  const auto ended = initdb->wait(60s);
  if (!ended || ended->status != 0)
    return failure(ErrorCode::unavailable, "initdb failed: " + (ended ? ended->output : ended.error().message));
  if (auto started = made->start(); !started) return tl::unexpected(started.error());
  return made;
}

PostgresCluster* PostgresCluster::of_this_process() {
  static auto cluster = make();
  EXPECT_TRUE(cluster) << cluster.error().message;
  return cluster ? cluster->get() : nullptr;
}

Result<void> PostgresCluster::start() {
  auto argv = as_unprivileged("postgres");
  argv.insert(argv.end(), {"-D", (folder_ / "data").string(), "-c", "listen_addresses=", "-c",
                           "unix_socket_directories=" + folder_.string(), "-c", "max_connections=40", "-c",
                           "shared_buffers=16MB", "-c", "recovery_init_sync_method=syncfs"});
  const auto deadline = std::chrono::steady_clock::now() + 60s;
  while (std::chrono::steady_clock::now() < deadline) {
    if (!server_ || server_->poll() >= 0) {  // it will not start while processes of the one before are about to end
      auto started = Process::start(argv, (folder_ / "server.log").string());
      if (!started) return tl::unexpected(started.error());
      server_.emplace(std::move(*started));
    }
    if (PQping(url("postgres").c_str()) == PQPING_OK) return {};
    std::this_thread::sleep_for(20ms);
  }
  return failure(ErrorCode::unavailable, "PostgreSQL does not start, see " + (folder_ / "server.log").string());
}

void PostgresCluster::kill() {
  if (!server_) return;
  const auto children = children_of(server_->pid());
  server_->signal(SIGKILL);
  for (const int child : children) ::kill(child, SIGKILL);
  (void)server_->wait(10s);
  server_.reset();
}

PostgresCluster::~PostgresCluster() {
  if (server_) {
    server_->signal(SIGQUIT);  // at once
    (void)server_->wait(10s);
  }
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
  if (lock_ >= 0) ::close(lock_);
}

std::string PostgresCluster::url(const std::string& database) const {
  return "postgresql:///" + database + "?host=" + folder_.string() + "&user=" + superuser;
}

Result<void> PostgresCluster::execute(const std::string& sql) {
  PGconn* connection = PQconnectdb(url("postgres").c_str());
  PGresult* result = PQexec(connection, sql.c_str());
  const bool good = PQresultStatus(result) == PGRES_COMMAND_OK || PQresultStatus(result) == PGRES_TUPLES_OK;
  const std::string why = PQerrorMessage(connection);
  PQclear(result);
  PQfinish(connection);
  if (!good) return failure(ErrorCode::unavailable, sql + ": " + why);
  return {};
}

Result<std::string> PostgresCluster::make_database() {
  const std::string name = "mine" + std::to_string(++databases_);
  if (auto made = execute("CREATE DATABASE " + name); !made) return tl::unexpected(made.error());
  return url(name);
}

}  // namespace headframe::test
