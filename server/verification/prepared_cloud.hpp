#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"
#include "server/verification/sight_image.hpp"

namespace headframe {

/// A keyframe's cloud, processed once on arrival: surfels for registration, and what each sweep saw for free-space
/// checks. Points that the keyframe's other sweeps see through (dust, people) are left out.
struct PreparedCloud {
  struct View {
    Eigen::Vector3f origin;  // in the keyframe's sensor frame
    SightImage image;
  };
  Points points;                                   // in the keyframe's sensor frame, one per prepared_leaf_m
  Points normals;                                  // one for each point, unit length, arbitrary sign
  std::shared_ptr<const std::vector<View>> views;  // separate, because submaps keep them longer than the points
};
inline constexpr float prepared_leaf_m = 0.25F;

std::size_t bytes_of(const PreparedCloud& cloud);

/// Bounds the cost for any input: at most 131072 points and 64 sweeps are used, and points that no sensor can have
/// measured are dropped.
PreparedCloud prepare(const KeyframeCloud& cloud, int threads = 1);

/// A prepared cloud with the pose that its session gives it.
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

/// The points of the clouds within radius_m of the centre, one surfel per leaf_m. The cost grows with the sphere only:
/// clouds of keyframes beyond radius_m + 12 m are ignored.
SurfelCloud sphere(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& centre, double radius_m, float leaf_m);

}  // namespace headframe
