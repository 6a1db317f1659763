// ./run bench: figures as ratios against a reference in the same run, as a table and as JSON.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "common/dataset/scan_file.hpp"
#include "server/place/wall_correlation.hpp"
#include "server/registration/gicp.hpp"
#include "tests/bench/link/link.hpp"
#include "tests/bench/pcl_gicp.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe::bench {
namespace {

/// Median over the runs, after one that is not counted.
template <class Work>
double median_ms(int runs, Work&& work) {
  std::vector<double> ms;
  for (int i = 0; i <= runs; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    if (i > 0)
      ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  std::nth_element(ms.begin(), ms.begin() + static_cast<std::ptrdiff_t>(ms.size() / 2), ms.end());
  return ms[ms.size() / 2];
}

struct Pair {
  std::string name;
  Points target, source;
  Pose T_target_source = Pose::Identity();
};

/// Two real scans where the recordings are there, else two scans of a drawn crossing.
Pair registration_pair(const std::filesystem::path& recordings) {
  const auto folder = recordings / "registration-pair";
  Pair pair;
  const auto target = load_scan(folder / "target.ply"), source = load_scan(folder / "source.ply");
  if (target && source) {
    pair = {"registration-pair", target->points, source->points, Pose::Identity()};
    std::ifstream in(folder / "T_target_source.txt");
    for (int i = 0; i < 16; ++i) in >> pair.T_target_source.matrix()(i / 4, i % 4);
  } else {
    const test::BoxMine mine({test::BoxMine::drift(-30, 0, 30, 0, 6), test::BoxMine::drift(0, -30, 0, 30)});
    std::mt19937 rng(1);
    const Pose a = pose_from_yaw(0, {0, 0, 1.5}), b = pose_from_yaw(0.05, {0.5, 0.1, 1.5});
    pair = {"drawn crossing", mine.scan(a, rng, 0.01, 64, 1024), mine.scan(b, rng, 0.01, 64, 1024), a.inverse() * b};
  }
  pair.target = voxel_grid(finite_points(pair.target, 0.3F), 0.25F);
  pair.source = voxel_grid(finite_points(pair.source, 0.3F), 0.25F);
  return pair;
}

void report_error(const char* who, const Pose& T, const Pose& truth) {
  const Pose error = truth.inverse() * T;
  std::printf("  %-22s %7.1f mm %7.3f deg from the truth\n", who, 1000 * error.translation().norm(),
              rotation_angle_rad(error) * 180 / std::numbers::pi);
}

nlohmann::json registration(const std::filesystem::path& recordings) {
  const Pair pair = registration_pair(recordings);
  std::printf("registration (%s, %zu and %zu points at 0.25 m)\n", pair.name.c_str(), pair.target.size(),
              pair.source.size());
  Pose T_pcl, T_own;
  const double pcl_ms = median_ms(5, [&] { T_pcl = pcl_gicp(pair.target, pair.source); });
  GicpConfig config;
  config.coarse_reach_m = config.fine_reach_m = 1.0;
  config.stages = 1;
  config.iterations = 30;
  config.gravity_stiffness = 0;
  const auto own_ms = [&](int threads) {
    config.threads = threads;
    return median_ms(9, [&] {
      T_own = align(make_surfels(pair.target, 20, threads), make_surfels(pair.source, 20, threads), Pose::Identity(),
                    config)
                  .T_target_source;
    });
  };
  const double one = own_ms(1), two = own_ms(2);
  const Surfels target = make_surfels(pair.target, 20, 2), source = make_surfels(pair.source, 20, 2);
  const double kept = median_ms(9, [&] { align(target, source, Pose::Identity(), config); });
  std::printf("  PCL GICP %.1f ms; ours with normals %.1f ms (1 thread), %.1f ms (2); alignment alone %.1f ms\n",
              pcl_ms, one, two, kept);
  std::printf("  vs PCL: %.2fx with 1 thread, %.2fx with 2; alignment alone %.2fx\n", pcl_ms / one, pcl_ms / two,
              pcl_ms / kept);
  report_error("PCL", T_pcl, pair.T_target_source);
  report_error("ours", T_own, pair.T_target_source);
  return {{"vs_pcl_1t", pcl_ms / one}, {"vs_pcl_2t", pcl_ms / two}, {"alignment_vs_pcl", pcl_ms / kept}};
}

nlohmann::json walls() {
  const test::BoxMine mine(
      {test::BoxMine::drift(0, 0, 120, 0), test::BoxMine::drift(30, 0, 30, 60), test::BoxMine::drift(80, -40, 80, 0)});
  const auto a = test::drive(mine, {{2, 0}, {30, 0}, {30, 58}}, 0, 1), b = test::drive(mine, {{118, 0}, {2, 0}}, 1, 2);
  const WallMap map_a = draw_wall_map(a.keyframes, 1), map_b = draw_wall_map(b.keyframes, 1);
  const double ms = median_ms(5, [&] { correlate(map_a, map_b, 20, 2); });
  std::printf("places\n  one pair of wall maps over all shifts and turns: %.0f ms (2 threads)\n", ms);
  return {{"wall_correlation_ms", ms}};
}

}  // namespace
}  // namespace headframe::bench

int main(int argc, char** argv) {
  using namespace headframe::bench;
  const std::string what = argc > 1 ? argv[1] : "all";
  if (what == "link") return link_main(argc - 1, argv + 1, "build/bench");  // "all" measures its bytes only
  const std::filesystem::path recordings = argc > 2 ? argv[2] : "../shared/data", out = "build/bench";
  std::filesystem::create_directories(out);
  bool known = false;
  const auto part = [&](const char* name, auto&& measure) {
    if (what != "all" && what != name) return;
    known = true;
    std::ofstream(out / (std::string(name) + ".json")) << nlohmann::json{{name, measure()}}.dump(1) << "\n";
  };
  part("registration", [&] { return registration(recordings); });
  part("link", [] { return link_bytes(); });
  part("places", [] { return walls(); });
  if (!known)
    std::fprintf(stderr, "headframe-bench: no bench '%s'; there are: registration, link, places, all\n", what.c_str());
  return known ? 0 : 2;
}
