#include "server/merge/session_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/support/keyframes.hpp"

namespace headframe {
namespace {

TEST(Session, PassesNearWhatAnyOfItsKeyframesLiesNear) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> step(-3, 3), place(-40, 40);
  Session session;
  Eigen::Vector3d here = Eigen::Vector3d::Zero();
  EXPECT_FALSE(session.passes_near(here, 5));
  for (std::uint64_t i = 1; i <= 200; ++i) {
    Keyframe k = line_keyframe(i);
    k.T_local_sensor.translation() = here;
    session.add(k);
    here += Eigen::Vector3d(step(rng), step(rng), step(rng) / 10) + (i % 40 == 0 ? 20 : 0) * Eigen::Vector3d::UnitX();
  }
  int near = 0, apart = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p(place(rng) + 30, place(rng), place(rng) / 10);
    for (const double reach_m : {2.0, 10.0, 35.0}) {
      const bool expected = std::any_of(session.keyframes.begin(), session.keyframes.end(), [&](const Keyframe& k) {
        return (k.T_local_sensor.translation() - p).norm() < reach_m;
      });
      ASSERT_EQ(session.passes_near(p, reach_m), expected) << p.transpose() << " " << reach_m;
      (expected ? near : apart) += 1;
    }
  }
  EXPECT_GT(near, 1000);
  EXPECT_GT(apart, 1000);
}

}  // namespace
}  // namespace headframe
