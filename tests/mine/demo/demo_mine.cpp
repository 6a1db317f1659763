#include "tests/mine/demo/demo_mine.hpp"

#include <fstream>
#include <numbers>

#include "tests/mine/lattice.hpp"
#include "tests/mine/session_folder.hpp"

namespace headframe::demo {
namespace {

constexpr std::uint64_t seed = 1;
constexpr double drive_m = 165;
const std::string version = "demo mine 2\n";  // to be counted up whenever the recordings change

/// Two rows of parallel drifts 14 to 17 m apart, joined into loops.
mine::Plan demo_plan() {
  const mine::Rng rng(seed);
  mine::Plan plan = mine::lattice_plan({.columns = 5,
                                        .rows = 4,
                                        .column_gap_m = {26, 38},
                                        .row_gap_m = {26, 34},
                                        .narrow_row_gap_m = {14, 17},
                                        .jitter_m = 4,
                                        .keep = 0.6,
                                        .bend = 0.12,
                                        .width_m = {3.6, 6.5},
                                        .height_m = {3, 4.6},
                                        .slope = 0.02,
                                        .waviness_m = 1.5},
                                       rng);
  mine::furnish(plan, rng.fork(1));
  plan.rock_seed = seed;
  return plan;
}

mine::Robot robot_of(const DemoRobot& robot, const mine::Plan& plan, double height_m) {
  mine::Robot out{.name = robot.name, .lidar = *mine::lidar_model(robot.sensor)};
  out.style.scan_spacing_m = 1;
  out.style.sensor_height_m = height_m;
  out.style.frame_yaw_rad = robot.frame_yaw_deg * std::numbers::pi / 180;
  out.style.drift = 0.8;
  out.dust = 0.001;
  out.route = mine::route_through(plan, robot.way, 4, drive_m);
  return out;
}

bool up_to_date(const std::filesystem::path& stamp) {
  std::ifstream in(stamp, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(in), {}) == version;
}

}  // namespace

const std::vector<DemoRobot>& demo_robots() {
  static const std::vector<DemoRobot> robots{{"scout", "os1-32", 0, {15, 10, 11, 12, 7, 6, 5}},
                                             {"mapper", "vlp16-hires", 135, {1, 2, 7, 12, 13, 14, 9}},
                                             {"hauler", "os1-32", 260, {19, 18, 17, 12, 11, 6, 7, 8}}};
  return robots;
}

Result<bool> prepare_recordings(const std::filesystem::path& dir) {
  const auto stamp = dir / "version.txt";
  if (up_to_date(stamp)) return false;
  const mine::World world = mine::build_world({demo_plan()});
  std::vector<mine::Recording> recordings;
  double height_m = 0.6;
  for (const DemoRobot& robot : demo_robots()) {
    recordings.push_back(mine::record(world, robot_of(robot, world.regions[0], height_m), seed));
    height_m += 0.5;
  }
  if (auto ok = mine::write_recordings(dir, "demo", "procedural demo", recordings); !ok)
    return tl::unexpected(ok.error());
  std::ofstream out(stamp, std::ios::binary);
  out << version << std::flush;
  if (!out) return failure(ErrorCode::unavailable, "cannot write " + stamp.string());
  return true;
}

}  // namespace headframe::demo
