#pragma once
// A robot's questions about the map that others made.

#include <Eigen/Core>
#include <cstdint>
#include <variant>

namespace headframe {

/// The version of a robot's copy of what others know, from an earlier answer. Its numbers have a meaning only for the
/// server.
struct HeldVersion {
  std::uint64_t epoch = 0;  // 0: nothing
  std::uint64_t version = 0;
  bool operator==(const HeldVersion&) const = default;
};

// A region of a robot's local frame.
struct SphereRegion {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double radius_m = 0;
};
struct BoxRegion {
  Eigen::Vector3d low_m = Eigen::Vector3d::Zero(), high_m = Eigen::Vector3d::Zero();
};
using Region = std::variant<SphereRegion, BoxRegion>;

}  // namespace headframe
