#pragma once

#include "server/verification/submap.hpp"

namespace headframe {

/// How a hypothesis is verified; defaults live only here. A "place" is a keyframe of b and the keyframe of a nearest to
/// it, with the submaps around both.
struct JudgeConfig {
  // Which places an overlap is judged at. Near ones first: farther apart, a corner hides from each what the other saw.
  // (A drawn pair with 80 % of its rock in common waited for one such place, two more in tunnel-two.)
  double close_m = 5;      // between the two keyframes of a place that is taken first ...
  double meet_m = 10;      // ... next; so near to each other, two paths meet ...
  double far_m = 18;       // ... and last, where neither path comes near the other: two lidars look into one hall
  double shared_m = 4;     // a metre of path is shared in full with another so near, and less and less up to ...
  double parted_m = 16;    // ... here: a crossing counts as much, wherever along it the keyframes stand
  double apart_m = 30;     // a hypothesis whose nearest keyframes stand farther apart is not looked at
  double look_m = 35;      // keyframes within this of the other session's take part
  std::size_t places = 6;  // at most

  // Screening.
  std::size_t screened_fully = 14;   // hypotheses that are registered in full, after a coarse registration of all
  double hopeless_inliers = 0.15;    // share at the first place below which a hypothesis is dropped
  double hopeless_violation = 0.08;  // share of violated points above which it is

  // How far a place may lie from where all together put it: the drift of both sessions.
  double place_drift_m = 1.5;
  double place_drift_share = 0.02;  // more, of its distance from the first place
  double place_drift_rad = 0.07;

  // What slides along a tunnel.
  double held_by_nothing = 0.009;  // weakest hold of a bare tunnel; 0.007 is the noise of scan lines
  double slide_m = 3;  // the placement is searched so far each way for where surfaces across the tunnel meet

  SubmapConfig place;
  int threads = 1;
};

}  // namespace headframe
