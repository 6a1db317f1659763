#pragma once
// One place of the overlap of two sessions: registered by itself, and asked whether both saw the same rock there.

#include <span>

#include "server/registration/submap.hpp"
#include "server/registration/vgicp.hpp"
#include "server/registration/visibility.hpp"

namespace headframe {

struct PlaceConfig {
  double radius_m = 18;  // of b's submap; a's reaches slack_m further
  double slack_m = 3;
  float leaf_m = 0.2F;       // of both submaps
  double look_m = 15;        // free space is asked of points nearer than this to the place ...
  float look_leaf_m = 0.6F;  // ... one per leaf
  double view_reach_m = 25;
  double slide_m = 4;  // of the slide test
};

struct PlaceCheck {
  Eigen::Vector3d p_a = Eigen::Vector3d::Zero(), p_b = Eigen::Vector3d::Zero();  // the place, in both local frames
  Registration registration;
  double residual_m = 1;    // median distance of b's surface from a's, in cubes of half a metre, along the normals
  double slide_ratio = 1;   // best share of points on a surface after a slide along the weakest direction / share here
  Visibility between, own;  // of each by the other; of each by itself, every other cloud
};

/// Registers b's submap around p_b on a's by VGICP, from T_a_b. Clouds are all that is there of each session near the
/// place, in the order of their sequence. Pure.
PlaceCheck register_place(std::span<const PlacedCloud> a, std::span<const PlacedCloud> b, const Eigen::Vector3d& p_b,
                          const Pose& T_a_b, const PlaceConfig& config);

/// Fills between and own, at T_a_b.
void look_at_place(PlaceCheck& place, std::span<const PlacedCloud> a, std::span<const PlacedCloud> b, const Pose& T_a_b,
                   const PlaceConfig& config);

}  // namespace headframe
