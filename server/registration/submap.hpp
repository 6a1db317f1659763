#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"
#include "server/registration/range_image.hpp"

namespace headframe {

/// A keyframe's cloud made ready once: thinned points for registration, and what each sweep saw for free-space checks.
struct PreparedCloud {
  struct View {
    Eigen::Vector3f origin;  // in the keyframe's sensor frame
    RangeImage image;
  };
  Points points;  // keyframe's sensor frame, one per prepared_leaf_m
  std::vector<View> views;
};
inline constexpr float prepared_leaf_m = 0.25F;

PreparedCloud prepare(const KeyframeCloud& cloud);

/// A prepared cloud where its session says it lies.
struct PlacedCloud {
  std::uint64_t sequence = 0;
  Pose T_local_sensor = Pose::Identity();
  std::shared_ptr<const PreparedCloud> cloud;
};

/// Points of one session in its local frame, one per leaf_m, within radius_m of the centre. Points that the session's
/// own later rays went through (dust, people, vehicles that drove on) are left out. Cost grows with the sphere.
Points sphere(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& centre, double radius_m, float leaf_m);

/// The same without a sphere: everything in these clouds.
Points merged(std::span<const PlacedCloud> clouds, float leaf_m);

/// FRAME, section on map merging: the sphere's radius from the local spacing of keyframes (m): 25 m at 10 m and above,
/// 15 m at 6 m, 10 m at 3 m, linear between (the paper gives the three points), 2 l below 3 m.
double sphere_radius_m(double keyframe_spacing_m);

}  // namespace headframe
