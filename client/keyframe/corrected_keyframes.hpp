#pragma once
// New poses of keyframes from a whole trajectory, as SLAM gives it after a loop closure. Pure: no clock, no I/O.

#include <span>
#include <vector>

#include "common/result.hpp"
#include "common/session/keyframe_pose.hpp"

namespace headframe {

/// The sensor's pose at a time, from SLAM.
struct TrajectoryPose {
  double stamp_s = 0;
  Pose T_local_sensor = Pose::Identity();
};

/// A keyframe that was added.
struct KnownKeyframe {
  double stamp_s = 0;
  Pose T_local_sensor = Pose::Identity();
  float spaciousness_m = 0;
};

struct CorrectionRules {
  double least_moved_m = 0.05;     // a keyframe that moves less than this ...
  double least_turned_rad = 0.01;  // ... and turns less than this is left unchanged
  double same_stamp_s = 0.001;     // stamps that differ by at most this are equal
  // A keyframe is interpolated between two poses of the trajectory that are at most most_gap_s apart, or at most
  // most_gap_m and most_gap_rad.
  double most_gap_s = 1;
  double most_gap_m = 1.5;
  double most_gap_rad = 0.5;
  bool later_ones = true;  // keyframes newer than the trajectory move with its end
};

struct CorrectedKeyframes {
  std::vector<KeyframePose> moved;  // by rising sequence, the first keyframe being 1
  std::size_t matched = 0;          // keyframes whose pose is in the trajectory, or interpolated
};

/// Keyframes whose stamps are in the trajectory, or that have poses close before and after, get their pose from it.
/// Those between two such keyframes move with both, weighted by time; those before the first, and after the last if
/// later_ones, move with it. Stamps of keyframes have to rise. invalid_argument: stamps of the trajectory that do not
/// rise, or a number that is not finite.
Result<CorrectedKeyframes> corrected_keyframes(std::span<const KnownKeyframe> keyframes,
                                               std::span<const TrajectoryPose> trajectory,
                                               const CorrectionRules& rules = {});

}  // namespace headframe
