#pragma once
// Collects what the robot saw between two keyframes. Pure: no clock, no I/O.

#include <deque>
#include <optional>

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"

namespace headframe {

struct SweepConfig {
  double distance_m = 1.0;                  // a scan is kept when the sensor moved this far since the last one kept,
  double rotation_rad = 0.523598775598299;  // or turned this much (30 deg)
  double clear_of_keyframe_m = 1.0;         // sweeps nearer to the keyframe than this add little and are dropped
  std::size_t most = 16;                    // sweeps between keyframes; beyond, the oldest is dropped
  float leaf_m = 0.1F;                      // every sweep is thinned to one point per cube of this edge
};

/// Collects thinned scans between two keyframes. Every scan of a session goes to one of the two calls: to take() if it
/// is a keyframe, else to add(). Points must be finite and without the zeros of missing returns (see finite_points),
/// poses finite. Not thread safe. Holds at most config.most thinned scans.
class SweepCollector {
 public:
  explicit SweepCollector(SweepConfig config = {});

  /// Keeps the scan if the sensor moved or turned enough since the last one kept or the last keyframe.
  /// intensity: one value for each point, or none.
  void add(const Pose& T_local_sensor, const Points& points_sensor, const Intensities& intensity = {});

  /// Returns the keyframe's cloud in its own sensor frame: the sweeps kept so far, oldest first, transformed by
  /// odometry, then the keyframe's own scan, also thinned, with origin zero (present even if empty). Empties the
  /// collector.
  KeyframeCloud take(const Pose& T_local_keyframe, const Points& own_scan, const Intensities& intensity = {});

 private:
  struct Kept {
    Pose T_local_sensor;
    Returns scan;  // in the sensor frame
  };
  SweepConfig config_;
  std::deque<Kept> kept_;
  std::optional<Pose> T_local_last_;  // of the last scan kept or the last keyframe
};

}  // namespace headframe
