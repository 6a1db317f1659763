#include <cstdio>
#include <memory>
#include <random>

#include "server/registration/sphere_index.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/registration.hpp"

namespace headframe::bench {
namespace {

constexpr std::size_t points_a_keyframe = 10'000;
constexpr double spacing_m = 2, drift_m = 400, between_drifts_m = 40;
constexpr int queries = 41;
constexpr double radius_m = 25;

/// Points on the walls of a drift 5 m wide and 4 m high, up to 20 m to both sides, in the keyframe's frame.
Points seen(std::mt19937& rng) {
  std::uniform_real_distribution<float> along(-20, 20), across(-2.5F, 2.5F), up(0, 4);
  std::uniform_int_distribution<int> side(0, 3);
  Points points(points_a_keyframe);
  for (auto& p : points) {
    const int wall = side(rng);
    p = {along(rng), wall < 2 ? across(rng) : (wall == 2 ? -2.5F : 2.5F),
         wall < 2 ? 4.0F * static_cast<float>(wall) : up(rng)};
  }
  return points;
}

/// Parallel drifts one after another, a keyframe every 2 m.
Pose place_of(std::size_t keyframe) {
  const double s = spacing_m * static_cast<double>(keyframe), drift = std::floor(s / drift_m);
  return pose_from_yaw(0, {s - drift * drift_m, between_drifts_m * drift, 0});
}

struct Figures {
  double ms = 0, points = 0, build_s = 0;
};

/// Every query is at another place, so nothing of it is in a cache, whatever the map's size.
Figures measure(std::size_t map_points) {
  const std::size_t keyframes = map_points / points_a_keyframe;
  SphereIndex index;
  std::mt19937 rng(1);
  Figures figures;
  figures.build_s = 1e-3 * wall_ms([&] {
                      for (std::size_t i = 0; i < keyframes; ++i)
                        index.add(place_of(i), std::make_shared<ChunkedCloud>(cut_into_chunks(seen(rng))));
                    });
  std::vector<double> ms, points;
  std::vector<char> elsewhere(std::size_t{64} << 20U);
  std::uniform_int_distribution<std::size_t> any(25, keyframes - 26);
  for (int i = 0; i < queries; ++i) {
    for (std::size_t b = 0; b < elsewhere.size(); b += 64) ++elsewhere[b];  // the caches forget the map
    const Eigen::Vector3d centre = place_of(any(rng)).translation();
    if (std::abs(centre.x() - drift_m / 2) > drift_m / 2 - 50 && keyframes > 200) continue;  // not the end of a drift
    SphereIndex::Sample sample;
    ms.push_back(wall_ms([&] { sample = index.sphere(centre, radius_m); }));
    points.push_back(static_cast<double>(sample.points.size()));
  }
  figures.ms = median(ms);
  figures.points = median(points);
  return figures;
}

}  // namespace

nlohmann::json sampling() {
  std::printf("sampling (spheres of %.0f m, cold caches, one thread; bar: 5 ms, and 1.5x from 1 to 100 million)\n",
              radius_m);
  nlohmann::json out;
  double first = 0;
  for (const std::size_t millions : {1U, 10U, 100U}) {
    const Figures f = measure(millions * 1'000'000);
    if (first == 0) first = f.ms;
    std::printf("  map of %3zu million points: %5.2f ms, %7.0f points in the sphere (map built in %.1f s)\n", millions,
                f.ms, f.points, f.build_s);
    std::fflush(stdout);
    const std::string name = std::to_string(millions) + "m";
    out["ms_" + name] = f.ms;
    out["points_" + name] = f.points;
    out["ratio_" + name + "_1m"] = f.ms / first;
  }
  std::printf("  sampling.ratio_100m_1m %.2f\n", out["ratio_100m_1m"].get<double>());
  return out;
}

}  // namespace headframe::bench
