// headframe-replay: plays a session folder through the robot library, as the robot would have.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <thread>

#include "client/robot_client.hpp"
#include "client/tools/replay_report.hpp"
#include "common/dataset/session_folder.hpp"
#include "common/dataset/text.hpp"
#include "common/endpoint.hpp"

namespace headframe {
namespace {

using Clock = std::chrono::steady_clock;

struct Options {
  std::string server, robot, folder, spool, credential, enrolment, fingerprint, corrected;
  std::string clouds = "all", family = RobotConfig().family;
  bool insecure = false, fast = false, provisional = false, localize = false, around = false, no_intensity = false;
  double map_radius_m = 0, rate = 1, linger_s = -1, patience_s = 30, bytes_per_s = 0;
};

int failed(const std::string& message, int status = 1) {
  std::fprintf(stderr, "headframe-replay: %s\n", message.c_str());
  return status;
}

std::chrono::milliseconds milliseconds(double s) { return std::chrono::milliseconds(static_cast<long>(s * 1000)); }

/// Prints the robot's warnings from number `told` on.
void tell(const RobotClient& robot, std::size_t& told, ReplayReport& report) {
  const auto warnings = robot.warnings();
  for (; told < warnings.size(); ++told) report.warning(warnings[told]);
}

/// Plays every scan at its time. A fault of the disk or of a file ends it; an unusable scan is skipped.
Result<void> play(const SessionFolder& session, const Options& options, RobotClient& robot, ReplayReport& report) {
  const auto start = Clock::now();
  std::size_t dropped = 0, told = robot.warnings().size();
  for (std::size_t i = 0; i < session.size(); ++i) {
    const std::chrono::duration<double> due((session.stamp_s(i) - session.stamp_s(0)) / options.rate);
    if (!options.fast) std::this_thread::sleep_until(start + std::chrono::duration_cast<Clock::duration>(due));
    const auto scan = session.load(i);
    if (!scan) return tl::unexpected(scan.error());
    dropped += scan->dropped;
    const auto added = robot.add_scan(session.stamp_s(i), session.T_local_sensor(i), scan->points, scan->intensity);
    if (!added && added.error().code == ErrorCode::bad_input)
      report.warning("scan " + std::to_string(i) + " passed over: " + added.error().message);
    else if (!added)
      return tl::unexpected(added.error());
    tell(robot, told, report);
    report.step(i + 1, robot.progress());
  }
  if (dropped > 0) report.line(std::to_string(dropped) + " points without a return (NaN or zero) were left out");
  return {};
}

/// A TUM trajectory of the sensor; empty without a file.
Result<std::vector<TrajectoryPose>> read_trajectory(const std::string& file) {
  constexpr std::uintmax_t most_bytes = std::uintmax_t{256} << 20U;
  std::vector<TrajectoryPose> out;
  if (file.empty()) return out;
  const auto text = dataset::read_file(file, most_bytes);
  if (!text) return tl::unexpected(text.error());
  const auto poses = dataset::parse_poses(*text);
  if (!poses) return failure(poses.error().code, file + ": " + poses.error().message);
  out.reserve(poses->size());
  for (const auto& pose : *poses) out.push_back({pose.stamp_s, pose.T_local_sensor});
  return out;
}

/// Applies the corrected trajectory, as SLAM would at the end of the drive after closing its loops.
Result<void> correct(const std::vector<TrajectoryPose>& corrected, const Options& options, RobotClient& robot,
                     ReplayReport& report) {
  if (options.corrected.empty()) return {};
  const auto done = robot.correct(corrected);
  if (!done) return tl::unexpected(done.error());
  if (done->matched == 0)
    return failure(ErrorCode::bad_input, options.corrected + ": it has no pose near the stamp of any keyframe");
  report.line(std::to_string(done->moved.size()) + " of " + std::to_string(robot.last_keyframe()) +
              " keyframes were moved by " + options.corrected);
  return {};
}

/// Stays connected until nothing was requested or acknowledged for this long, or the server has ended the session.
void linger(double linger_s, std::size_t scans, const RobotClient& robot, ReplayReport& report) {
  constexpr std::uint64_t more_than_pings = 4096;
  auto last = robot.progress();
  auto quiet_since = Clock::now();
  while (Clock::now() - quiet_since < milliseconds(linger_s)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const auto now = robot.progress();
    report.step(scans, now);
    if (now.refused) return;
    if (now.clouds_acknowledged == last.clouds_acknowledged && now.bytes_sent < last.bytes_sent + more_than_pings)
      continue;
    last = now;
    quiet_since = Clock::now();
  }
}

/// Requests the map of all robots around the last scan, each time the robot learns where others are.
void ask_for_map(const Options& options, const SessionFolder& session, RobotClient& robot, ReplayReport& report) {
  if (options.map_radius_m <= 0 || session.size() == 0) return;
  const SphereRegion sphere{session.T_local_sensor(session.size() - 1).translation(), options.map_radius_m};
  robot.map_around({sphere}, [&](const MapAround& map) { report.map(map); });
}

Result<void> run(const Options& options, const SessionFolder& session, const std::vector<TrajectoryPose>& corrected,
                 RobotClient& robot) {
  ReplayReport report(session.size());
  for (const auto& warning : session.warnings()) report.warning(warning);
  std::size_t told = 0;
  tell(robot, told, report);
  const SessionKey mine = robot.session();
  const auto before = robot.progress().keyframes;
  report.line((before > 0 ? "resumes session " : "session ") + mine.robot + "/" + mine.session +
              (before > 0 ? " after keyframe " + std::to_string(before) : ""));
  robot.on_transform([&](const Transforms& t) {
    report.transforms(mine, t);
    ask_for_map(options, session, robot, report);
  });
  if (options.localize) robot.localize([&](const Localization& l) { report.localization(l); });

  if (options.around) robot.trajectories([&](const Trajectories& t) { report.trajectories(t); });
  if (options.around) robot.coverage([&](const Coverage& c) { report.coverage(c); });

  auto done = play(session, options, robot, report);
  if (done) done = correct(corrected, options, robot, report);
  if (done)
    done = robot.finish(milliseconds(options.patience_s), [&](const Progress& p) { report.step(session.size(), p); });
  if (done) linger(options.linger_s, session.size(), robot, report);
  if (const auto last = robot.progress(); done && last.refused) done = failure(ErrorCode::refused, last.link_error);
  robot.close();
  report.end(robot.progress());
  return done;
}

int replay(Options options) {
  RobotConfig config;
  const auto servers = parse_peers(options.server);
  if (!servers) return failed("--server: " + servers.error().message, 2);
  config.host = servers->front().host;
  config.port = servers->front().port;
  config.more_servers.assign(servers->begin() + 1, servers->end());
  const auto session = SessionFolder::open(options.folder);
  if (!session) return failed(session.error().message);
  const auto corrected = read_trajectory(options.corrected);
  if (!corrected) return failed(corrected.error().message);
  config.robot = options.robot;
  config.insecure = options.insecure;
  config.enrolment = options.enrolment;
  config.fingerprint = options.fingerprint;
  config.credential = options.credential;
  if (options.credential.empty() && options.spool.empty()) config.credential = options.robot + ".credential";
  config.sensor = session->sensor();
  config.family = options.family;
  config.bytes_per_s = options.bytes_per_s;
  config.provisional = options.provisional;
  config.intensity = !options.no_intensity;
  config.clouds = options.clouds == "all"     ? CloudPolicy::all
                  : options.clouds == "never" ? CloudPolicy::never
                                              : CloudPolicy::on_request;
  if (options.linger_s < 0) options.linger_s = config.clouds == CloudPolicy::on_request ? 30 : 0;
  config.spool = options.spool;
  if (options.spool.empty()) {
    std::string name = (std::filesystem::temp_directory_path() / "headframe-replay-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) return failed(name + ": can not be made; give --spool DIR");
    config.spool = name;
  }

  const auto robot = RobotClient::open(config);
  const auto done = robot ? run(options, *session, *corrected, **robot) : tl::unexpected(robot.error());
  std::error_code ignored;
  if (options.spool.empty() && (done || !robot)) std::filesystem::remove_all(config.spool, ignored);
  if (done) return 0;
  if (!robot) return failed(robot.error().message);
  return failed(done.error().message + "; what is spooled is safe: go on with --spool " + config.spool.string());
}

}  // namespace
}  // namespace headframe

int main(int argc, char** argv) {
  headframe::Options o;
  CLI::App app{"Plays a recorded session through the robot library, as the robot would have."};
  app.add_option("--server", o.server,
                 "base station, HOST:PORT; given again, or after a comma: those that stand by for it")
      ->required()
      ->join(',');
  app.add_option("--robot", o.robot, "name of the robot")->required();
  app.add_option("--spool", o.spool,
                 "directory that keeps the session; without it a temporary one, removed on success");
  app.add_option("--enrol", o.enrolment, "what `headframe robot add NAME` printed; needed the first time only");
  app.add_option("--credential", o.credential,
                 "file of what it got then; without it ROBOT.credential beside the spool, or here without a spool");
  app.add_option("--fingerprint", o.fingerprint, "of the server's certificate, if not the one of the enrolment");
  app.add_flag("--insecure", o.insecure, "in the clear and unknown, to a server that runs with --insecure");
  auto* fast = app.add_flag("--fast", o.fast, "as fast as the disk and the processor allow");
  constexpr double most = 1e9;
  app.add_option("--rate", o.rate, "times real time")
      ->capture_default_str()
      ->check(CLI::Range(1e-3, most))
      ->excludes(fast);
  app.add_option("--clouds", o.clouds, "which clouds to send")
      ->capture_default_str()
      ->check(CLI::IsMember({"all", "on_request", "never"}));
  app.add_option("--corrected", o.corrected,
                 "TUM trajectory of the sensor as SLAM has it at the end: keyframes that it moves are told then");
  app.add_flag("--no-intensity", o.no_intensity, "leave out how strong the returns were, which exports show");
  app.add_option(
         "--family", o.family,
         "what describes a keyframe: learned, scan_context, lidar_iris, or onnx:FILE (with FILE.json beside it)")
      ->capture_default_str();
  app.add_flag("--provisional", o.provisional, "print merges that still wait for path, too; nothing to drive by");
  app.add_flag("--localize", o.localize, "ask where the robot is in the map of others, and print the answers");
  app.add_flag("--around", o.around, "print the paths of others, and what was seen of the mine, as they come");
  app.add_option("--map", o.map_radius_m, "ask for the map of all robots, so many metres around the last scan")
      ->check(CLI::Range(0, 200));
  app.add_option("--linger", o.linger_s, "stay so many seconds after the last answer (30 with on_request, else 0)")
      ->check(CLI::Range(0.0, most));
  app.add_option("--patience", o.patience_s, "give up after so many seconds without progress")
      ->capture_default_str()
      ->check(CLI::Range(0.0, most));
  app.add_option("--bytes-per-s", o.bytes_per_s, "budget of the link; 0: no limit")
      ->capture_default_str()
      ->check(CLI::Range(0.0, most));
  app.add_option("SESSION_DIR", o.folder, "scans/, poses.txt and sensor.json")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  return headframe::replay(std::move(o));
}
