#include "server/atlas/relax.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace headframe {
namespace {

// Three sessions, each of which meets the next far from where they began: the loop that their alignments make fails to
// close by 0.5 m and 0.6 deg.
using Ids = std::array<SessionId, 3>;
using Origins = std::array<Pose, 3>;                                                    // T_world_session
const std::array<Eigen::Vector3d, 3> places{{{60, 0, 1}, {60, 70, 0}, {-20, 40, -1}}};  // of pairs 0-1, 1-2 and 0-2
constexpr std::array<std::array<std::size_t, 2>, 3> pairs{{{0, 1}, {1, 2}, {0, 2}}};

const Pose& misread() {
  static const Pose T = pose_from_yaw(0.01, {0.4, -0.3, 0.05});
  return T;
}

const Origins& some_origins() {
  static const Origins T{pose_from_yaw(0, {0, 0, 0}), pose_from_yaw(2, {90, 40, 0}), pose_from_yaw(-1, {-60, 90, 2})};
  return T;
}

/// The alignments, as these names make them: a < b. The third is misread about the place where its two meet.
std::vector<Alignment> edges(const Ids& ids, const Origins& T_world) {
  std::vector<Alignment> out;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto [one, other] = pairs.at(i);
    Pose T_one_other = T_world.at(one).inverse() * T_world.at(other);
    if (i == 2) {
      const Eigen::Translation3d here(places.at(2));
      T_one_other = T_world.at(one).inverse() * (here * misread() * here.inverse()) * T_world.at(other);
    }
    Alignment k;
    k.a = std::min(ids.at(one), ids.at(other)), k.b = std::max(ids.at(one), ids.at(other));
    k.T_a_b = k.a == ids.at(one) ? T_one_other : T_one_other.inverse();
    out.push_back(k);
  }
  return out;
}

/// Where the world's origin lies then, of sessions 1 and 2 in the world of session 0.
std::array<Pose, 2> relaxed(const Ids& ids, const Origins& T_world, bool where_they_meet) {
  Frames frames;
  for (std::size_t i = 0; i < 3; ++i) frames[ids.at(i)] = T_world[0].inverse() * T_world.at(i);
  const auto place = [&](const Alignment& k) {
    const auto index = [&](SessionId id) {
      return static_cast<std::size_t>(std::find(ids.begin(), ids.end(), id) - ids.begin());
    };
    const std::size_t sum = index(k.a) + index(k.b);  // 1, 3, 2
    return Eigen::Vector3d(T_world.at(index(k.b)).inverse() * places.at(sum == 1 ? 0 : sum == 3 ? 1 : 2));
  };
  relax(frames, edges(ids, T_world), {}, where_they_meet ? Meetings(place) : Meetings());
  const auto world_by = [&](std::size_t i) {
    return Pose(T_world[0] * frames.at(ids[0]).inverse() * frames.at(ids.at(i)) * T_world.at(i).inverse());
  };
  return {world_by(1), world_by(2)};
}

double most_apart_m(const std::array<Pose, 2>& one, const std::array<Pose, 2>& other) {
  double most = 0;
  for (std::size_t i = 0; i < one.size(); ++i)
    for (const Eigen::Vector3d& p : places) most = std::max(most, (one.at(i) * p - other.at(i) * p).norm());
  return most;
}

TEST(Relax, NeitherNamesNorFramesOfSessionsMoveThem) {
  Ids ids{1, 2, 3};
  const auto first = relaxed(ids, some_origins(), true);
  EXPECT_GT((first[1] * places[2] - places[2]).norm(), 0.05) << "the misread loop is shared out";
  double without = 0;
  do {
    EXPECT_LT(most_apart_m(first, relaxed(ids, some_origins(), true)), 0.005) << ids[0] << ids[1] << ids[2];
    without =
        std::max(without, most_apart_m(relaxed({1, 2, 3}, some_origins(), false), relaxed(ids, some_origins(), false)));
  } while (std::next_permutation(ids.begin(), ids.end()));
  EXPECT_GT(without, 0.03) << "errors of the origins hang on who is called a";
  Origins elsewhere = some_origins();
  elsewhere[1] = elsewhere[1] * pose_from_yaw(3, {-40, 200, 5});
  elsewhere[2] = elsewhere[2] * pose_from_yaw(1, {70, 0, -3});
  EXPECT_LT(most_apart_m(first, relaxed({1, 2, 3}, elsewhere, true)), 0.005);
}

TEST(Relax, WhatAgreesStaysWhereItIs) {
  Frames frames;
  const Origins& T_world = some_origins();
  for (std::size_t i = 0; i < 3; ++i) frames[static_cast<SessionId>(i + 1)] = T_world[0].inverse() * T_world.at(i);
  auto agreeing = edges({1, 2, 3}, T_world);
  agreeing[2].T_a_b = T_world[0].inverse() * T_world[2];
  relax(frames, agreeing, {}, [](const Alignment&) { return Eigen::Vector3d(30, -20, 1); });
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_TRUE(frames.at(static_cast<SessionId>(i + 1)).isApprox(T_world[0].inverse() * T_world.at(i), 1e-9));
}

}  // namespace
}  // namespace headframe
