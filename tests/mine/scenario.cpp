#include "tests/mine/scenario.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "tests/mine/parallel.hpp"

namespace headframe::mine {
namespace {

constexpr double everywhere_m = 1e9;

/// Quick eyes, to compare routes before the real scans are made.
SeenVoxels glance(const World& world, const Route& route) {
  const LidarModel eyes = noiseless({.name = "eyes", .beams = 20, .columns = 160});
  SeenVoxels voxels(1.0);
  std::vector<Scan> scans((route.size() + 3) / 4);
  std::vector<Pose> poses(scans.size(), Pose::Identity());
  for_each_index(scans.size(), [&](std::size_t i) {
    poses[i].translation() = route[4 * i] + Eigen::Vector3d(0, 0, 1);
    scans[i] = take_scan(world.caster, eyes, poses[i], 0, Rng(0));
  });
  for (std::size_t i = 0; i < scans.size(); ++i) voxels.add(scans[i].points, poses[i], everywhere_m);
  return voxels;
}

std::vector<Route> candidates(const Plan& plan, double wanted_m, std::size_t count, const Rng& rng) {
  std::vector<Route> routes;
  for (std::uint64_t i = 0; i < 20 * count && routes.size() < count; ++i) {
    Route route = random_route(plan, wanted_m, rng.fork(i));
    if (length_m(route) > 0.9 * wanted_m) routes.push_back(std::move(route));
  }
  return routes;
}

struct Choice {
  Route route;
  double overlap_pct = std::numeric_limits<double>::infinity();
};

/// The candidate whose overlap with the earlier routes is nearest to the wish: many are judged by their plan, the best
/// of these by what a lidar sees.
Choice choose_route(const World& world, const std::vector<Route>& routes, const std::vector<Route>& earlier,
                    double wish_pct) {
  std::vector<SeenVoxels> known;
  known.reserve(earlier.size());
  for (const Route& route : earlier) known.push_back(glance(world, route));
  const double planned = wish_pct > 0 ? std::max(0.02, wish_pct / 100 - 0.15) : 0;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < routes.size(); ++i) {
    double share = 0;
    for (const Route& route : earlier) share = std::max(share, shared_part(routes[i], route, wish_pct > 0 ? 4 : 15));
    order.emplace_back(std::abs(share - planned), i);
  }
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  Choice best;
  for (std::size_t k = 0; k < std::min<std::size_t>(order.size(), 24); ++k) {
    const Route& route = routes[order[k].second];
    const SeenVoxels view = glance(world, route);
    double overlap = 0;
    for (const SeenVoxels& other : known) overlap = std::max(overlap, overlap_pct(view, other));
    if (std::abs(overlap - wish_pct) < std::abs(best.overlap_pct - wish_pct)) best = {route, overlap};
    if (std::abs(best.overlap_pct - wish_pct) < (wish_pct > 0 ? 2.0 : 1e-9)) break;
  }
  return best;
}

Result<void> check(const Request& request) {
  const auto wrong = [](const std::string& what) { return failure(ErrorCode::invalid_argument, what); };
  if (request.robots < 1 || request.robots > 16) return wrong("--robots has to be 1 to 16");
  if (!(request.overlap_pct >= 0 && request.overlap_pct <= 95)) return wrong("--overlap has to be 0 to 95 percent");
  if (!(request.length_m >= 10 && request.length_m <= 1000)) return wrong("--length has to be 10 to 1000 m");
  if (!(request.scan_spacing_m >= 0.5 && request.scan_spacing_m <= 10)) return wrong("--spacing has to be 0.5 to 10 m");
  if (!(request.drift >= 0 && request.drift <= 10)) return wrong("--drift has to be 0 to 10");
  if (!(request.dust >= 0 && request.dust <= 1)) return wrong("--dust has to be 0 to 1");
  if (request.sensors.empty()) return wrong("--sensors needs a name");
  for (const std::string& name : request.sensors)
    if (!lidar_model(name)) return wrong("no sensor '" + name + "'; there are os1-32, vlp16-hires, hdl-32e, os0-64");
  return {};
}

Robot make_robot(const Request& request, int number, Rng rng) {
  const std::string& sensor = request.sensors[static_cast<std::size_t>(number) % request.sensors.size()];
  Robot robot{.name = std::string("r").append(std::to_string(number + 1)), .lidar = *lidar_model(sensor)};
  robot.style.scan_spacing_m = request.scan_spacing_m;
  robot.style.sensor_height_m = rng.uniform(0.4, 2.0);
  robot.style.tilt_sigma_rad = rng.uniform(0.005, 0.025);
  robot.style.drift = request.drift;
  robot.style.frame_yaw_rad = number == 0 ? 0 : rng.uniform(0, 2 * std::numbers::pi);
  robot.dust = request.dust;
  return robot;
}

/// A region of its own for each robot, out of everybody's sight.
Plan remote_region(const Request& request, int number) {
  const std::uint64_t seed = mix_bits(request.seed + 7919 * static_cast<std::uint64_t>(number));
  return moved(make_plan(request.kind, seed), Eigen::Vector3d(0, 2000.0 * number, 0));
}

}  // namespace

World build_world(std::vector<Plan> regions) {
  Mesh mesh;
  for (const Plan& plan : regions) append(mesh, mesh_of(plan));
  return {std::move(regions), RayCaster(mesh)};
}

Result<Scenario> make_scenario(const Request& request) {
  if (auto ok = check(request); !ok) return tl::unexpected(ok.error());
  const Rng rng = Rng(request.seed).fork(1000 + static_cast<std::uint64_t>(request.kind));
  const bool apart = request.overlap_pct == 0;
  std::vector<Plan> regions{make_plan(request.kind, request.seed)};
  for (int k = 1; k < request.robots && apart && request.kind == Kind::look_alike; ++k)
    regions.push_back(remote_region(request, k));
  Scenario scenario{build_world(std::move(regions)), {}};
  std::vector<Route> earlier;
  for (int k = 0; k < request.robots; ++k) {
    const auto salt = static_cast<std::uint64_t>(k);
    Robot robot = make_robot(request, k, rng.fork(salt));
    const std::size_t own = std::min(static_cast<std::size_t>(k), scenario.world.regions.size() - 1);
    const auto routes =
        candidates(scenario.world.regions[own], request.length_m, k == 0 ? 1 : 400, rng.fork(100 + salt));
    Choice choice;
    if (k == 0 && !routes.empty())
      choice = {routes.front(), 0};
    else if (apart)
      choice = choose_route(scenario.world, routes, earlier, 0);
    else
      choice = choose_route(scenario.world, routes, {earlier.back()}, request.overlap_pct);
    if (apart && choice.overlap_pct > 0) {  // the mine is too small for this: give the robot another one
      scenario.world.regions.push_back(remote_region(request, k));
      scenario.world = build_world(std::move(scenario.world.regions));
      const auto others = candidates(scenario.world.regions.back(), request.length_m, 1, rng.fork(200 + salt));
      if (!others.empty()) choice.route = others.front();
    }
    if (choice.route.empty())
      return failure(ErrorCode::invalid_argument, "no way of that length through this mine; take a shorter --length");
    robot.route = choice.route;
    earlier.push_back(robot.route);
    scenario.robots.push_back(std::move(robot));
  }
  return scenario;
}

Recording record(const World& world, const Robot& robot, std::uint64_t seed) {
  const Rng rng = Rng(seed).fork(mix_bits(std::hash<std::string>{}(robot.name)));
  Recording recording{robot, drive_along(robot.route, robot.style, world.caster, rng.fork(1)), {}};
  recording.scans.resize(recording.drive.T_world_sensor.size());
  for_each_index(recording.scans.size(), [&](std::size_t i) {
    recording.scans[i] =
        take_scan(world.caster, robot.lidar, recording.drive.T_world_sensor[i], robot.dust, rng.fork(1000 + i));
  });
  return recording;
}

SeenVoxels seen(const Recording& recording, double voxel_m, double max_range_m) {
  SeenVoxels voxels(voxel_m);
  for (std::size_t i = 0; i < recording.scans.size(); ++i)
    voxels.add(recording.scans[i].points, recording.drive.T_world_sensor[i], max_range_m);
  return voxels;
}

}  // namespace headframe::mine
