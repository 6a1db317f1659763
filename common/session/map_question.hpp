#pragma once
// What a robot asks of the map that others made.

#include <Eigen/Core>
#include <cstdint>
#include <variant>

namespace headframe {

/// What a robot holds of what others know, as an earlier answer said. Its numbers mean something to the server alone.
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
