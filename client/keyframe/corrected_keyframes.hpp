#pragma once
// Where keyframes lie by a whole trajectory, as SLAM gives it after a loop closure. Pure: no clock, no I/O.

#include <span>
#include <vector>

#include "common/result.hpp"
#include "common/session/keyframe_pose.hpp"

namespace headframe {

/// The sensor's pose at a time, by SLAM.
struct TrajectoryPose {
  double stamp_s = 0;
  Pose T_local_sensor = Pose::Identity();
};

/// A keyframe as the robot knows it.
struct KnownKeyframe {
  double stamp_s = 0;
  Pose T_local_sensor = Pose::Identity();
  float spaciousness_m = 0;
};

struct CorrectionRules {
  double least_moved_m = 0.05;     // a keyframe that moved by less than this ...
  double least_turned_rad = 0.01;  // ... and turned by less than this stays
  double same_stamp_s = 0.001;     // stamps that differ by no more are the same
  double most_gap_s = 1;           // a keyframe lies between two poses of the trajectory that are no farther apart,
  double most_gap_m = 1.5;         // or no farther than this,
  double most_gap_rad = 0.5;       // turned by no more than this
  bool later_ones = true;          // those that are newer than the trajectory are carried along with its end
};

struct CorrectedKeyframes {
  std::vector<KeyframePose> moved;  // by rising sequence, the first keyframe being 1
  std::size_t matched = 0;          // keyframes whose pose the trajectory says
};

/// Keyframes whose stamps the trajectory has, or has poses close before and after, lie where it says. Those between two
/// of them move as both do, the nearer one in time counting more; those before the first of them, and after the last if
/// later_ones, move with it. Stamps of keyframes rise. invalid_argument: a stamp of the trajectory that is not after
/// the one before, or a number that is not finite.
Result<CorrectedKeyframes> corrected_keyframes(std::span<const KnownKeyframe> keyframes,
                                               std::span<const TrajectoryPose> trajectory,
                                               const CorrectionRules& rules = {});

}  // namespace headframe
