#include <algorithm>
#include <array>
#include <cstdio>
#include <random>

#include "server/atlas/merge_graph.hpp"
#include "server/merge/alignment_edges.hpp"
#include "server/merge/corrected_poses.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/pose_graph.hpp"

namespace headframe::bench {
namespace {

constexpr double step_m = 1, block_m = 50;
constexpr std::size_t keyframes = 300;

/// Drives over a lattice of streets, with the drift of odometry.
struct Walker {
  std::vector<Pose> truth, believed;

  Walker(std::mt19937_64& random, int blocks) {
    std::normal_distribution<double> off(0, 1);
    std::uniform_int_distribution<int> place(0, blocks);
    Eigen::Vector3d at(block_m * place(random), block_m * place(random), 0);
    std::array<Eigen::Vector3d, 4> ways{Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), -Eigen::Vector3d::UnitX(),
                                        -Eigen::Vector3d::UnitY()};
    std::size_t way = static_cast<std::size_t>(place(random)) % 4;
    Pose T_believed = Pose::Identity();
    for (std::size_t i = 0; i < keyframes; ++i) {
      if (i % 50 == 0) way = (way + (random() % 2 == 0 ? 1 : 3)) % 4;
      const Pose T = pose_from_yaw(std::atan2(ways.at(way).y(), ways.at(way).x()), at);
      if (i > 0)
        T_believed = T_believed * truth.back().inverse() * T *
                     pose_from_yaw(5e-4 * off(random), {0.012 * off(random), 0.012 * off(random), 0.008 * off(random)});
      truth.push_back(T);
      believed.push_back(T_believed);
      at += step_m * ways.at(way);
    }
  }
};

struct World {
  std::vector<Walker> walkers;
  MergeConfig config;
  SessionMap sessions{config};
  std::vector<Alignment> alignments;
  std::vector<PairClosures> closures;
  Component component{1, {}};
};

/// Where the two meet: at most four places of an overlap, with the error of a registration.
std::optional<Alignment> met(World& world, SessionId a, SessionId b, std::mt19937_64& random) {
  std::normal_distribution<double> off(0, 1);
  const Walker &in_a = world.walkers[static_cast<std::size_t>(a - 1)],
               &in_b = world.walkers[static_cast<std::size_t>(b - 1)];
  Alignment out;
  out.a = a, out.b = b;
  out.state = AlignmentState::published;
  std::vector<PoseConstraint> places;
  for (std::size_t k = 0; k < keyframes && places.size() < 4; k += 20)
    for (std::size_t i = 0; i < keyframes; i += 2) {
      if ((in_a.truth[i].translation() - in_b.truth[k].translation()).norm() > 4) continue;
      Registration r;
      const Pose noise =
          pose_from_yaw(2e-3 * off(random), {0.04 * off(random), 0.04 * off(random), 0.04 * off(random)});
      r.T_target_source =
          in_a.believed[i] * noise * in_a.truth[i].inverse() * in_b.truth[k] * in_b.believed[k].inverse();
      r.information.diagonal() << 1e6, 1e6, 1e6, 1e4, 1e4, 1e4;
      r.centre = in_a.believed[i].translation();
      places.push_back(constraint_between({a, i + 1}, in_a.believed[i], {b, k + 1}, in_b.believed[k], place_fit(r)));
      out.T_a_b = r.T_target_source;
      break;
    }
  if (places.empty()) return std::nullopt;
  world.closures.push_back({a, b, std::make_shared<const std::vector<PoseConstraint>>(std::move(places))});
  return out;
}

}  // namespace

nlohmann::json pose_graph_scale(std::size_t count, std::size_t alignments) {
  std::mt19937_64 random(5);
  World world;
  const int blocks = static_cast<int>(std::sqrt(static_cast<double>(count) * 2));
  for (std::size_t s = 0; s < count; ++s) {
    world.walkers.emplace_back(random, blocks);
    const auto id = static_cast<SessionId>(s + 1);
    world.sessions.add(id, {});
    for (std::size_t i = 0; i < keyframes; ++i) {
      Keyframe k;
      k.sequence = i + 1;
      k.stamp_s = static_cast<double>(i);
      k.T_local_sensor = world.walkers[s].believed[i];
      world.sessions.add_keyframe(id, std::move(k));
    }
  }
  for (SessionId b = 2; b <= static_cast<SessionId>(count); ++b)
    for (SessionId a = 1; a < b; ++a)
      if (auto alignment = met(world, a, b, random)) world.alignments.push_back(std::move(*alignment));
  std::shuffle(world.alignments.begin(), world.alignments.end(), random);
  world.alignments.resize(std::min(alignments, world.alignments.size()));
  std::vector<SessionId> ids(count);
  for (std::size_t i = 0; i < count; ++i) ids[i] = static_cast<SessionId>(i + 1);
  const auto last = static_cast<SessionId>(count);
  std::vector<Alignment> without = world.alignments;
  std::erase_if(without, [&](const Alignment& k) { return k.a == last || k.b == last; });
  CorrectedPoses poses(world.sessions);
  for (const PairClosures& pair : world.closures) poses.set(pair);
  std::vector<Component> components = merge_sessions(ids, without).components;
  const double all_ms = wall_ms([&] { poses.update(components, without); });
  components = merge_sessions(ids, world.alignments).components;
  const double one_ms = wall_ms([&] { poses.update(components, world.alignments); });
  std::vector<Component> same = merge_sessions(ids, world.alignments).components;
  const double none_ms = wall_ms([&] { poses.update(same, world.alignments); });
  const std::size_t largest = std::max_element(components.begin(), components.end(), [](const auto& a, const auto& b) {
                                return a.placements.size() < b.placements.size();
                              })->placements.size();
  std::printf(
      "  %zu sessions, %zu keyframes, %zu alignments, %zu sessions in the largest component: all at once %.1f s, one "
      "session more (%zu alignments) %.2f s, nothing new %.3f s\n",
      count, count * keyframes, world.alignments.size(), largest, all_ms / 1000,
      world.alignments.size() - without.size(), one_ms / 1000, none_ms / 1000);
  return {{"all_s", all_ms / 1000}, {"optimise_s", one_ms / 1000}, {"nothing_s", none_ms / 1000}};
}

}  // namespace headframe::bench
