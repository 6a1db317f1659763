#pragma once
// One place of the overlap of two sessions: registered by itself, and asked whether both saw the same rock there.

#include "server/verification/change_patches.hpp"
#include "server/verification/submap.hpp"

namespace headframe {

/// How much of b's submap a's map can speak of, and how much of that lies on a surface of a's. Rock that a never saw
/// says nothing, so a short overlap is judged by what it shares. Points are asked evenly, 500 at most.
struct Matched {
  double on = 0, comparable = 0;
  double share() const { return comparable > 0 ? on / comparable : 0; }
  /// With 40 points more that do not match: few points prove little.
  double cautious() const { return on / (comparable + 40); }
};

struct SubmapCheck {
  Eigen::Vector3d p_a = Eigen::Vector3d::Zero(), p_b = Eigen::Vector3d::Zero();  // the place, in both local frames
  Registration registration;
  double residual_m = 1;      // median distance of b's surface from a's, in cubes of half a metre, along the normals
  Matched matched;            // where it was registered
  Visibility a_by_b, b_by_a;  // the rock of each from the sweeps of the other
  std::vector<ChangePatch> changes;  // violations that time may explain, in a's frame

  Visibility between() const;  // both ways together
  double unexplained() const;  // share of violations that are no part of a change
};

/// At T_a_b.
Matched matched(const Submap& a, const Submap& b, const Pose& T_a_b);

/// Registers b's submap on a's from T_a_b, by config.engine. Pure.
SubmapCheck register_submaps(const Submap& a, const Submap& b, const Pose& T_a_b, const SubmapConfig& config);

/// Fills what it looks like, at T_a_b, and what may have changed where the two were not recorded in the same hour.
void check_free_space(SubmapCheck& check, const Submap& a, const Submap& b, const Pose& T_a_b,
                      const SubmapConfig& config);

/// What it looks like where it contradicts least of two: where its own registration put it, and at T_a_b. By itself a
/// place of a smooth tunnel slides a metre and more along it, and then sees through walls that bend; at T_a_b it is off
/// by the drift of the odometry. Other rock contradicts at both.
void check_free_space_again(SubmapCheck& check, const Submap& a, const Submap& b, const Pose& T_a_b,
                            const SubmapConfig& config);

}  // namespace headframe
