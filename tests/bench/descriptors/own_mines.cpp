#include "tests/bench/descriptors/own_mines.hpp"

#include "tests/mine/open_directions.hpp"

namespace headframe::bench {
namespace {

/// With shorter drives where the mine is too small for long ones.
Result<mine::Scenario> scenario_of(mine::Kind kind, std::uint64_t seed) {
  mine::Request request;
  request.kind = kind;
  request.seed = seed;
  request.overlap_pct = 50;
  request.scan_spacing_m = 2;
  for (request.length_m = 120;; request.length_m -= 20) {
    auto scenario = mine::make_scenario(request);
    if (scenario || request.length_m < 60) return scenario;
  }
}

Drive drive_with(const mine::Scenario& scenario, std::size_t robot, const std::string& lidar, double dust,
                 std::uint64_t seed) {
  mine::Robot equipped = scenario.robots[robot];
  equipped.lidar = mine::lidar_model(lidar).value();
  equipped.dust = dust;
  return drive_of(mine::record(scenario.world, equipped, seed));
}

Drives drives_in(const mine::Scenario& scenario, double dust, std::uint64_t seed) {
  return {drive_with(scenario, 0, "os1-32", dust, seed), drive_with(scenario, 1, "os1-32", dust, seed),
          drive_with(scenario, 1, "vlp16-hires", dust, seed)};
}

std::vector<bool> junctions_of(const Drive& drive, const mine::RayCaster& caster) {
  std::vector<bool> out;
  out.reserve(drive.size());
  for (const View& view : drive) out.push_back(mine::open_directions(caster, view.T_world_level) >= 3);
  return out;
}

}  // namespace

Result<OwnMine> dig(mine::Kind kind, std::uint64_t seed) {
  const auto scenario = scenario_of(kind, seed);
  if (!scenario) return tl::unexpected(scenario.error());
  OwnMine out;
  out.kind = kind;
  out.seed = seed;
  out.clean = drives_in(*scenario, 0, seed);
  if (in_headline(kind)) out.dusty = drives_in(*scenario, bench_dust, seed);
  out.same = truth_of(out.clean.a, out.clean.b_same);
  out.cross = truth_of(out.clean.a, out.clean.b_cross);
  out.junction_a = junctions_of(out.clean.a, scenario->world.caster);
  out.junction_b = junctions_of(out.clean.b_same, scenario->world.caster);
  return out;
}

Result<mine::Recording> dense_recording() {
  const auto scenario = scenario_of(mine::Kind::junctions, first_own_seed);
  if (!scenario) return tl::unexpected(scenario.error());
  mine::Robot robot = scenario->robots.front();
  robot.lidar.columns = 1024;
  return mine::record(scenario->world, robot, first_own_seed);
}

}  // namespace headframe::bench
