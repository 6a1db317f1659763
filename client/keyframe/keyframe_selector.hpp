#pragma once
// Chooses which scans become keyframes: FRAME's selection by spaciousness, plus an occasional keyframe where the robot
// was before. Pure: no clock, no I/O.

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"
#include "common/session/keyframe_pose.hpp"

namespace headframe {

/// Tolerance by which a step of exactly a threshold counts as reaching it.
inline constexpr double step_rounding = 1e-9;

struct KeyframeConfig {
  float smoothing = 0.9F;                   // the weight of s_{k-1} in s_k = 0.9 s_{k-1} + 0.1 S_k
  double rotation_rad = 0.523598775598299;  // 30 deg
  double least_threshold_m = 0.5;  // so that a covered lidar, or one in a shaft, does not make every scan a keyframe
  double known_after_m = 95;       // path after which a place counts as known ground; by then drift has grown
  double known_spacing_m = 20;     // path between keyframes on known ground
};

/// The distance between keyframes for a spaciousness s: 10 m if s > 10; 6 m if 6 < s <= 10; 3 m if 3 < s <= 6; else s.
double distance_threshold_m(float spaciousness_m);

/// S_k: mean distance of the points from the sensor; 0 for an empty scan.
float mean_range_m(const Points& points_sensor);

/// Takes the scans of one session in order. Not thread safe. Memory grows with the keyframes chosen, about 150 bytes
/// each.
class KeyframeSelector {
 public:
  explicit KeyframeSelector(KeyframeConfig config = {});

  struct Decision {
    bool keyframe = false;
    float spaciousness_m = 0;  // s_k, also when the scan is no keyframe
  };

  /// Decides on one scan. The first scan is a keyframe. A later one is a keyframe if
  /// - no earlier keyframe (including the last) is nearer than the threshold, or
  /// - the sensor turned by at least rotation_rad since the last keyframe, and no keyframe nearer than the threshold
  ///   was oriented within rotation_rad of it, or
  /// - the path has grown by known_spacing_m since the last keyframe, and by known_after_m since every keyframe nearer
  ///   than the threshold. This deviates from the paper, which sends nothing on known ground; but the server needs it
  ///   to find where a robot that comes round again closes a loop.
  /// The path counts only steps of 1 m and more, so that noise in the pose of a robot at rest is not path.
  /// A mean range that is not finite and positive (an empty scan) leaves the spaciousness unchanged. A pose that is not
  /// finite or farther than 1e9 m from the origin never becomes a keyframe.
  Decision add(const Pose& T_local_sensor, float mean_range_m);

  /// Adds a keyframe that was chosen before a restart, in order; afterwards add() decides as if there had been no
  /// restart. The pose must be finite and within 1e9 m.
  void restore(const Pose& T_local_sensor, float spaciousness_m);

  /// Number of keyframes chosen or restored.
  std::size_t size() const { return keyframes_.size(); }

  /// Sets new poses of keyframes, numbered from 1; afterwards add() decides as if all had been restored with these
  /// poses. spaciousness_m: of the last keyframe. Throws std::out_of_range for a number without a keyframe. The cost is
  /// that of the moved keyframes plus one addition for every keyframe.
  void move(std::span<const KeyframePose> moved, float spaciousness_m);

 private:
  struct Nearby {
    bool any = false;       // an earlier keyframe is nearer than the threshold
    bool same_way = false;  // one of these has the same orientation
    bool lately = false;    // one of these was added less than known_after_m of path ago
  };
  struct Chosen {
    Pose T_local_sensor;
    double path_m = 0;  // driven when it was added
  };
  void smooth(float mean_range_m);
  void drive_to(const Eigen::Vector3d& p_local);
  void remember(const Pose& T_local_sensor);
  bool is_keyframe(const Pose& T_local_sensor) const;
  Nearby nearby(const Pose& T_local_sensor, double threshold_m) const;

  KeyframeConfig config_;
  float spaciousness_m_ = 0;
  double path_m_ = 0;
  std::optional<Eigen::Vector3d> path_end_local_;
  std::vector<Chosen> keyframes_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells_;  // cube of the grid -> its keyframes
};

}  // namespace headframe
