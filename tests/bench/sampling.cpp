#include <cstdio>
#include <random>

#include "server/verification/submap.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/registration.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe::bench {
namespace {

constexpr double spacing_m = 2;
constexpr int repeats = 11;

}  // namespace

/// What the server pays once for each 3 m of path: clouds made ready, and the submap of a keyframe from all clouds of
/// the path 45 m to both sides. A session's other clouds are not looked at, so the size of the map does not matter.
nlohmann::json sampling() {
  const SubmapConfig config;
  const test::BoxMine mine({test::BoxMine::drift(-100, 0, 100, 0), test::BoxMine::drift(0, -30, 0, 30)});
  std::mt19937 rng(1);
  std::vector<PlacedCloud> clouds;
  std::vector<double> prepared_ms, submap_ms;
  for (double x = -config.window_m; x <= config.window_m; x += spacing_m) {
    const Pose T = pose_from_yaw(0, {x, 0, 1.5});
    const KeyframeCloud cloud{{{Eigen::Vector3f::Zero(), mine.scan(T, rng, 0.01, 32, 1024)}}};
    std::shared_ptr<const PreparedCloud> prepared;
    prepared_ms.push_back(wall_ms([&] { prepared = std::make_shared<const PreparedCloud>(prepare(cloud)); }));
    clouds.push_back({clouds.size() + 1, T, std::move(prepared)});
  }
  std::size_t points = 0;
  for (int round = 0; round < repeats; ++round)
    submap_ms.push_back(wall_ms([&] {
      points = make_submap(clouds, {0.1 * round, 0, 1.5}, config).source.points.size();
    }));
  std::printf("sampling (one thread; %zu clouds of 32 x 1024 beams, %.0f m of path each way)\n", clouds.size(),
              config.window_m);
  std::printf("  a cloud made ready %5.1f ms; a submap %5.1f ms, %zu points in its source\n", median(prepared_ms),
              median(submap_ms), points);
  return {{"cloud_ms", median(prepared_ms)}, {"submap_ms", median(submap_ms)}};
}

}  // namespace headframe::bench
