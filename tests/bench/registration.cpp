#include "tests/bench/registration.hpp"

#include <cstdio>
#include <fstream>
#include <numbers>
#include <random>

#include "common/dataset/scan_file.hpp"
#include "server/registration/pcl_gicp.hpp"
#include "server/registration/vgicp.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/registration/gicp.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe::bench {
namespace {

constexpr int rounds = 11;
constexpr float leaf_m = 0.25F;
constexpr std::size_t neighbours = 20;

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
  pair.target = voxel_grid(finite_points(pair.target, 0.3F), leaf_m);
  pair.source = voxel_grid(finite_points(pair.source, 0.3F), leaf_m);
  return pair;
}

/// As PCL is asked to do it: one stage, 1 m. In one stage far partners have to guide to the end, so the kernel is as
/// wide as the reach; and points 0.25 m apart on ground that is rough by centimetres are planes to one in a hundred.
GicpConfig as_pcl(int threads) {
  GicpConfig config;
  config.coarse_reach_m = config.fine_reach_m = 1.0;
  config.stages = 1;
  config.iterations = 30;
  config.gravity_stiffness = 0;
  config.factor = {.plane_epsilon = 1e-2, .kernel_share = 1};
  config.threads = threads;
  return config;
}

nlohmann::json error_of(const char* who, const Pose& T, const Pose& truth) {
  const Pose error = truth.inverse() * T;
  const double mm = 1000 * error.translation().norm(), deg = rotation_angle_rad(error) * 180 / std::numbers::pi;
  std::printf("  %-34s %6.1f mm %7.3f deg from the truth\n", who, mm, deg);
  return {{"mm", mm}, {"deg", deg}};
}

}  // namespace

nlohmann::json registration(const std::filesystem::path& recordings) {
  const Pair pair = registration_pair(recordings);
  std::printf("registration (%s, %zu and %zu points at %.2f m, k = %zu, 1 m, from identity)\n", pair.name.c_str(),
              pair.target.size(), pair.source.size(), static_cast<double>(leaf_m), neighbours);
  Pose T_pcl, T_own, T_vgicp;
  std::vector<double> pcl_ms, one_ms, two_ms, kept_ms, vgicp_ms, vs_1t, vs_2t, vs_kept, vs_vgicp;
  const auto both = [&](int threads) {
    return wall_ms([&] {
      const Surfels target = make_surfels(pair.target, neighbours, threads),
                    source = make_surfels(pair.source, neighbours, threads);
      T_own = align(target, source, Pose::Identity(), as_pcl(threads)).T_target_source;
    });
  };
  const Surfels target = make_surfels(pair.target, neighbours, 2), source = make_surfels(pair.source, neighbours, 2);
  for (int round = 0; round <= rounds; ++round) {
    const double pcl = wall_ms([&] { T_pcl = pcl_gicp(pair.target, pair.source); });
    const double one = both(1), two = both(2);
    const double kept = wall_ms([&] { align(target, source, Pose::Identity(), as_pcl(1)); });
    const double vgicp = wall_ms([&] {
      T_vgicp = align(make_voxel_maps(target.points, target.normals), source.points, source.normals, Pose::Identity())
                    .T_target_source;
    });
    if (round == 0) continue;  // warms up
    pcl_ms.push_back(pcl), one_ms.push_back(one), two_ms.push_back(two), kept_ms.push_back(kept);
    vgicp_ms.push_back(vgicp);
    vs_vgicp.push_back(pcl / vgicp);
    vs_1t.push_back(pcl / one), vs_2t.push_back(pcl / two), vs_kept.push_back(pcl / kept);
  }
  std::printf("  PCL GICP                           %6.1f ms\n", median(pcl_ms));
  std::printf(
      "  VGICP, which the server runs       %6.1f ms   registration.vgicp_vs_pcl     %4.1f  (kept normals, maps "
      "made)\n",
      median(vgicp_ms), median(vs_vgicp));
  std::printf("  GICP with normals, 1 thread        %6.1f ms   registration.vs_pcl_1t       %5.2f  (bar 2.2)\n",
              median(one_ms), median(vs_1t));
  std::printf("  GICP with normals, 2 threads       %6.1f ms   registration.vs_pcl_2t       %5.2f  (bar 4.2)\n",
              median(two_ms), median(vs_2t));
  std::printf("  GICP, kept normals, 1 thread       %6.1f ms   registration.alignment_vs_pcl %4.1f  (bar 5)\n",
              median(kept_ms), median(vs_kept));
  nlohmann::json out{{"pair", pair.name},
                     {"pcl_ms", median(pcl_ms)},
                     {"own_1t_ms", median(one_ms)},
                     {"own_2t_ms", median(two_ms)},
                     {"alignment_ms", median(kept_ms)},
                     {"vgicp_ms", median(vgicp_ms)},
                     {"vs_pcl_1t", median(vs_1t)},
                     {"vs_pcl_2t", median(vs_2t)},
                     {"alignment_vs_pcl", median(vs_kept)},
                     {"vgicp_vs_pcl", median(vs_vgicp)}};
  out["pcl_error"] = error_of("PCL", T_pcl, pair.T_target_source);
  out["own_error"] = error_of("GICP", T_own, pair.T_target_source);
  out["own_default_error"] = error_of(
      "GICP, its own defaults", align(target, source, Pose::Identity(), {}).T_target_source, pair.T_target_source);
  out["vgicp_error"] = error_of("VGICP", T_vgicp, pair.T_target_source);
  return out;
}

}  // namespace headframe::bench
