#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"
#include "server/verification/sight_image.hpp"

namespace headframe {

/// A keyframe's cloud made ready once, when it arrives: surfels for registration, and what each sweep saw for
/// free-space checks. Points that the keyframe's own other sweeps see through (dust, people) are left out.
struct PreparedCloud {
  struct View {
    Eigen::Vector3f origin;  // in the keyframe's sensor frame
    SightImage image;
  };
  Points points;                                   // keyframe's sensor frame, one per prepared_leaf_m
  Points normals;                                  // one a point, unit; their sign carries no meaning
  std::shared_ptr<const std::vector<View>> views;  // apart: places keep them longer than the points
};
inline constexpr float prepared_leaf_m = 0.25F;

std::size_t bytes_of(const PreparedCloud& cloud);

/// Whatever the cloud holds, it costs what a large honest one does: at most 131072 points and 64 sweeps are used, and
/// none that a sensor cannot have seen.
PreparedCloud prepare(const KeyframeCloud& cloud, int threads = 1);

/// A prepared cloud where its session says it lies.
struct PlacedCloud {
  std::uint64_t sequence = 0;
  Pose T_local_sensor = Pose::Identity();
  std::shared_ptr<const PreparedCloud> cloud;
  double stamp_s = 0;  // by the robot's clock
};

/// Surfels of one session in its local frame.
struct SurfelCloud {
  Points points, normals;
};
std::size_t bytes_of(const SurfelCloud& submap);

/// What the clouds hold within radius_m of the centre, one surfel per leaf_m. Cost grows with the sphere: clouds from
/// keyframes beyond radius_m + 12 m are not looked at.
SurfelCloud sphere(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& centre, double radius_m, float leaf_m);

}  // namespace headframe
