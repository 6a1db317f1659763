#include "server/merge/session_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "tests/support/keyframes.hpp"

namespace headframe {
namespace {

TEST(Session, KnowsHowFarItsNearestKeyframeIs) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> step(-3, 3), place(-40, 40);
  Session session;
  EXPECT_EQ(session.distance_m({0, 0, 0}), std::numeric_limits<double>::infinity());
  Eigen::Vector3d here = Eigen::Vector3d::Zero();
  for (std::uint64_t i = 1; i <= 200; ++i) {
    Keyframe k = line_keyframe(i);
    k.T_local_sensor.translation() = here;
    session.add(k);
    here += Eigen::Vector3d(step(rng), step(rng), step(rng) / 10) + (i % 40 == 0 ? 20 : 0) * Eigen::Vector3d::UnitX();
  }
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p(place(rng) + 30, place(rng), place(rng) / 10);
    double expected = std::numeric_limits<double>::infinity();
    for (const Keyframe& k : session.keyframes)
      expected = std::min(expected, (k.T_local_sensor.translation() - p).norm());
    ASSERT_NEAR(session.distance_m(p), expected, 1e-9) << p.transpose();
  }
}

}  // namespace
}  // namespace headframe
