#pragma once
// Keyframes to compare descriptors on: what was seen from where, and which of two drives show the same place.

#include <filesystem>
#include <string>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"
#include "tests/mine/scenario.hpp"

namespace headframe::bench {

/// A keyframe as the robot describes it, and its true pose.
struct View {
  Points points_level;  // levelled sensor frame
  Pose T_world_level = Pose::Identity();
};
using Drive = std::vector<View>;

/// Every scan of a simulated drive.
Drive drive_of(const mine::Recording& recording);

/// A recorded session, thinned to keyframes 2 m apart. Throws std::runtime_error when it cannot be read.
Drive read_drive(const std::filesystem::path& recording, const std::string& robot);

/// The scans turned by 10 deg about a random horizontal axis each: a tilt that the levelling does not know.
Drive tilted(const Drive& drive, std::uint64_t seed);

/// The scan of a robot that stands there turned by yaw_rad.
Points turned(const Points& points_level, double yaw_rad);

/// Drive b's keyframes asked of drive a's.
struct Truth {
  std::vector<std::vector<std::size_t>> right;  // for each of b the right ones of a, ascending
  std::vector<double> yaw_a_rad, yaw_b_rad;     // headings in the world

  /// Of frame b[j] in frame a[i].
  double yaw_difference_rad(std::size_t i, std::size_t j) const { return wrap_rad(yaw_b_rad[j] - yaw_a_rad[i]); }
};
Truth truth_of(const Drive& a, const Drive& b);

}  // namespace headframe::bench
