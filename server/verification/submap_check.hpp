#pragma once
// One place of the overlap of two sessions, registered independently, with its free space checked.

#include "server/verification/change_patches.hpp"
#include "server/verification/submap.hpp"

namespace headframe {

/// How many of b's points lie in space that a's map knows, and how many of these lie on a surface of a's. Rock that a
/// never saw does not count, so a short overlap is judged by what it shares. Uses at most 500 evenly chosen points.
struct Matched {
  double on = 0, comparable = 0;
  double share() const { return comparable > 0 ? on / comparable : 0; }
  /// The share with 40 further points that do not match, because few points prove little.
  double cautious() const { return on / (comparable + 40); }
};

struct SubmapCheck {
  Eigen::Vector3d p_a = Eigen::Vector3d::Zero(), p_b = Eigen::Vector3d::Zero();  // of the place, in each local frame
  Registration registration;
  double residual_m = 1;      // median distance along the normals of b's surface from a's, in cubes of half a metre
  Matched matched;            // at the registered transform
  Visibility a_by_b, b_by_a;  // the rock of each session seen from the sweeps of the other ...
  std::vector<PointSight> of_a, of_b;  // ... and each point of it by itself
  std::vector<ChangePatch> changes;    // violations that changes of the mine may explain, in a's frame

  Visibility between() const;  // sum of both
  double unexplained() const;  // share of violations that no change explains
};

/// At T_a_b.
Matched matched(const Submap& a, const Submap& b, const Pose& T_a_b);

/// Registers b's submap on a's from T_a_b with config.engine. Where the keyframes stand farther apart than
/// config.beside_m, the coarsest level is left out, and T_a_b has to be right to within a metre or two. Pure.
SubmapCheck register_submaps(const Submap& a, const Submap& b, const Pose& T_a_b, const SubmapConfig& config);

/// Sets the visibilities at T_a_b and, if the two were not recorded within the same hour, the changes.
void check_free_space(SubmapCheck& check, const Submap& a, const Submap& b, const Pose& T_a_b,
                      const SubmapConfig& config);

/// Checks the free space again at T_a_b and keeps the result if it contradicts less than the one at the place's own
/// registration. Registered alone, a place in a smooth tunnel may slide a metre or more along it and then see through
/// walls at a bend; at T_a_b it is off only by the drift of odometry. Rock of another place contradicts at both.
void check_free_space_again(SubmapCheck& check, const Submap& a, const Submap& b, const Pose& T_a_b,
                            const SubmapConfig& config);

/// T_a_b moved to where the place's own registration puts the place, but not along the direction that holds it least: a
/// place that was registered alone may slide along its tunnel, while drift across the tunnel can be seen.
Pose moved_across(const SubmapCheck& place, const Pose& T_a_b);

}  // namespace headframe
