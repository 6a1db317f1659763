#pragma once

#include "server/verification/submap.hpp"

namespace headframe {

/// How a hypothesis is verified; defaults live only here. A "place" is a keyframe of b and the nearest keyframe of a,
/// with the submaps around both.
struct JudgeConfig {
  // The places at which an overlap is judged, those with near keyframes first: farther apart, corners hide from each
  // session what the other saw. (Without this order a pair of a drawn mine with 80 % of its rock in common, and two in
  // tunnel-two, had to wait.)
  double close_m = 5;      // greatest distance between the two keyframes of a place, at first ...
  double meet_m = 10;      // ... then; two paths meet where they are this near ...
  double far_m = 18;       // ... and last, if the paths never meet: two lidars look into one hall
  double shared_m = 4;     // path counts as shared in full if the other path is this near, less and less up to ...
  double parted_m = 16;    // ... here; so a crossing counts the same wherever the keyframes happen to lie
  double apart_m = 30;     // a hypothesis whose nearest keyframes are farther apart is not judged
  double look_m = 35;      // keyframes within this distance of the other session's are used
  std::size_t places = 6;  // limit of places

  // Screening.
  std::size_t screened_fully = 14;   // hypotheses that are registered fully, after all were registered coarsely
  std::size_t further_places = 2;    // at which a hypothesis is tried that failed at the first place
  double hopeless_inliers = 0.15;    // inlier fraction at the first place below which a hypothesis is dropped
  double hopeless_violation = 0.08;  // share of violated points above which it is dropped

  // Where at least this share of the first place's points is violated, the farthest place is looked at before the
  // others, and these not at all if it shows the second share. Of 677 placements in five worlds 155 showed the second
  // share, the likeliest of which had a probability of .019 by all its places, 90 of them the first one too; as did 4
  // of 347 with a probability above .3.
  double doubted_violation = 0.001, refuting_violation = 0.02;

  // How far a place's own registration may differ from the common one: the drift of both sessions since the place that
  // was registered first.
  double place_drift_m = 1.5;
  double place_drift_share = 0.02;  // plus this share of its distance from the first place
  double place_drift_rad = 0.07;
  double drift_allowed_m(double from_first_m) const { return place_drift_m + place_drift_share * from_first_m; }
  /// With the tolerance for drift between a place and what is seen from it: 0.3 m of 15 m, 0.5 m of 25 m. Screening
  /// does without, because the limits by which it counts copies were set without.
  SubmapConfig with_drift(SubmapConfig of_places) const {
    of_places.look_slack_m = static_cast<float>(place_drift_share * of_places.look_m);
    return of_places;
  }

  // Placements that slide along a tunnel.
  double held_by_nothing = 0.009;  // weakest hold below which a tunnel is bare; 0.007 is the noise of scan lines
  double slide_m = 3;              // surfaces across the tunnel are matched over slides of up to this, both ways

  SubmapConfig place;
  int threads = 1;
};

}  // namespace headframe
