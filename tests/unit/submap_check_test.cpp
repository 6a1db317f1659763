#include "server/verification/submap_check.hpp"

#include <gtest/gtest.h>

#include "tests/support/drawn_session.hpp"

namespace headframe {
namespace {

/// The rock around the middle of a drawn drive along a straight drift with a branch.
Submap drawn_submap() {
  const test::Drive drive = test::drive_a_to_c(2);
  std::vector<PlacedCloud> clouds;
  for (std::size_t i = 0; i < drive.keyframes.size(); ++i)
    clouds.push_back({drive.keyframes[i].sequence, drive.keyframes[i].T_local_sensor,
                      std::make_shared<const PreparedCloud>(prepare(drive.clouds[i])), 0});
  return make_submap(clouds, drive.keyframes[6].T_local_sensor.translation(), {});
}

TEST(SubmapCheck, DriftAcrossATunnelIsNotAContradictionThoughThePlaceSlidAlongIt) {
  const Submap rock = drawn_submap();
  const SubmapConfig config;
  const SubmapCheck alone = register_submaps(rock, rock, Pose::Identity(), config);
  const Eigen::Vector3d along = alone.registration.weakest_direction;
  const Eigen::Vector3d across = along.cross(Eigen::Vector3d::UnitZ()).normalized();
  Pose T_drifted = Pose::Identity();
  T_drifted.translation() = 1.2 * across;
  SubmapCheck slid = alone;
  slid.p_a += 3 * along;
  const auto violation_at = [&](const Pose& T) {
    SubmapCheck check = slid;
    check_free_space(check, rock, rock, T, config);
    return check.between().violation();
  };
  EXPECT_GT(violation_at(T_drifted), 0.015);
  const Pose T_across = moved_across(slid, T_drifted);
  EXPECT_LT(T_across.translation().norm(), 0.05) << "back by the drift, and by nothing along the tunnel";
  EXPECT_LT(violation_at(T_across), 0.002);
  T_drifted.translation() = 3 * along;
  EXPECT_NEAR(moved_across(alone, T_drifted).translation().norm(), 3, 0.05) << "what slides does not move it";
}

TEST(SubmapCheck, OnlyKeyframesThatAreNearAreRegisteredByTheCoarsestLevel) {
  const Submap rock = drawn_submap();
  const Pose off = pose_from_yaw(0, {0, 3, 0});  // across the tunnel
  const double apart_m = (off * rock.p - rock.p).norm();
  const auto error_m = [&](double beside_m) {
    SubmapConfig config;
    config.beside_m = beside_m;
    return (register_submaps(rock, rock, off, config).p_a - rock.p).norm();
  };
  EXPECT_LT(error_m(apart_m + 0.01), 0.05);
  EXPECT_GT(error_m(apart_m - 0.01), 0.5) << "too far for the finer levels";
}

}  // namespace
}  // namespace headframe
