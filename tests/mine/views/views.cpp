#include "tests/mine/views/views.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>

#include "common/descriptor/learned/input.hpp"
#include "tests/mine/open_directions.hpp"
#include "tests/mine/parallel.hpp"

namespace headframe::mine {
namespace {

constexpr std::array view_sensors{"os1-32", "vlp16-hires", "hdl-32e", "os0-64"};
constexpr double seen_within_m = 20, near_m = 25;

/// A lidar, a height, a temper and the air of the day.
Robot drawn_robot(Route route, double spacing_m, Rng rng) {
  const double draw = rng.uniform();
  const std::size_t sensor = draw < 0.35 ? 0 : draw < 0.7 ? 1 : draw < 0.85 ? 2 : 3;
  Robot robot{.name = {}, .lidar = *lidar_model(view_sensors[sensor])};
  robot.style.scan_spacing_m = spacing_m;
  robot.style.sensor_height_m = rng.uniform(0.4, 2.5);
  robot.style.tilt_sigma_rad = rng.uniform(0.005, 0.03);
  robot.dust = rng.chance(0.3) ? rng.uniform(0, 0.03) : 0;
  robot.route = std::move(route);
  return robot;
}

/// What the robot takes for level: gravity is known to a degree or two; now and then a robot knows it badly.
Eigen::Matrix3d level_error(Rng& rng) {
  const double deg = std::numbers::pi / 180;
  const double tilt = rng.chance(0.1) ? rng.uniform(0, 10 * deg) : 0.7 * deg * rng.normal();
  const double towards = rng.uniform(0, 2 * std::numbers::pi);
  return Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(towards), std::sin(towards), 0)).toRotationMatrix();
}

struct Seen {
  View view;
  SeenVoxels voxels{1.0};
};

Seen see(const RayCaster& caster, const Robot& robot, const Pose& T_world_sensor, Rng rng) {
  const Scan scan = take_scan(caster, robot.lidar, T_world_sensor, robot.dust, rng.fork(1));
  Seen seen;
  seen.voxels.add(scan.points, T_world_sensor, seen_within_m);
  const Pose T_world_level = levelled(T_world_sensor);
  Rng tilt = rng.fork(2);
  const Eigen::Matrix3f R =
      (level_error(tilt) * T_world_level.linear().transpose() * T_world_sensor.linear()).cast<float>();
  Points points_level;
  points_level.reserve(scan.points.size());
  for (const auto& p : scan.points) points_level.emplace_back(R * p);
  seen.view.place_m = T_world_sensor.translation().cast<float>();
  seen.view.yaw_rad = static_cast<float>(yaw_rad(T_world_level));
  seen.view.ways = open_directions(caster, T_world_sensor);
  seen.view.image = learned_input(points_level);
  return seen;
}

std::vector<ViewPair> pairs_of(const std::vector<Seen>& seen) {
  std::vector<std::vector<ViewPair>> rows(seen.size());
  for_each_index(seen.size(), [&](std::size_t i) {
    for (std::size_t j = i + 1; j < seen.size(); ++j) {
      if ((seen[i].view.place_m - seen[j].view.place_m).norm() > near_m) continue;
      const auto share = static_cast<int>(overlap_pct(seen[i].voxels, seen[j].voxels));
      if (share > 0) rows[i].push_back({static_cast<int>(i), static_cast<int>(j), share});
    }
  });
  std::vector<ViewPair> pairs;
  for (const auto& row : rows) pairs.insert(pairs.end(), row.begin(), row.end());
  return pairs;
}

template <class T>
void put(std::ofstream& out, const T& value) {
  out.write(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

Views take_views(Kind kind, std::uint64_t seed, int routes, double length_m, double spacing_m) {
  const World world = build_world({make_plan(kind, seed)});
  const Rng rng = Rng(seed).fork(5000);
  std::vector<Seen> seen;
  for (int k = 0; k < 2 * routes; ++k) {
    const Rng own = rng.fork(static_cast<std::uint64_t>(k));
    Route route = random_route(world.regions.front(), length_m, rng.fork(1000 + static_cast<std::uint64_t>(k / 2)));
    if (Rng turn = own.fork(1); k % 2 == 1 && turn.chance(0.5)) std::reverse(route.begin(), route.end());
    const Robot robot = drawn_robot(std::move(route), spacing_m, own.fork(2));
    const Drive drive = drive_along(robot.route, robot.style, world.caster, own.fork(3));
    const std::size_t first = seen.size();
    seen.resize(first + drive.T_world_sensor.size());
    for_each_index(drive.T_world_sensor.size(), [&](std::size_t i) {
      seen[first + i] = see(world.caster, robot, drive.T_world_sensor[i], own.fork(1000 + i));
      seen[first + i].view.drive = k;
      seen[first + i].view.sensor = static_cast<int>(
          std::find(view_sensors.begin(), view_sensors.end(), robot.lidar.name) - view_sensors.begin());
    });
  }
  Views out{{}, pairs_of(seen)};
  out.views.reserve(seen.size());
  for (Seen& s : seen) out.views.push_back(std::move(s.view));
  return out;
}

Result<void> write_views(const Views& views, const std::filesystem::path& file) {
  std::ofstream out(file, std::ios::binary);
  const RangeImageSpec spec;
  out.write("HFV1", 4);
  for (const std::size_t n : {views.views.size(), spec.rows, spec.columns, views.pairs.size()})
    put(out, static_cast<std::uint32_t>(n));
  for (const View& v : views.views) {
    for (const float f : {v.place_m.x(), v.place_m.y(), v.place_m.z(), v.yaw_rad}) put(out, f);
    for (const int i : {v.sensor, v.ways, v.drive}) put(out, i);
  }
  for (const View& v : views.views) {
    const auto planes = log_range_and_mask(v.image);
    const std::size_t n = v.image.range_m.size();
    for (std::size_t i = 0; i < n; ++i)
      put(out, planes[n + i] > 0 ? static_cast<std::int16_t>(std::lround(1000 * planes[i]))
                                 : std::numeric_limits<std::int16_t>::min());
  }
  for (const ViewPair& p : views.pairs)
    for (const int i : {p.a, p.b, p.overlap_pct}) put(out, i);
  if (!out.flush()) return failure(ErrorCode::unavailable, "cannot write " + file.string() + "; is the disk full?");
  return {};
}

}  // namespace headframe::mine
