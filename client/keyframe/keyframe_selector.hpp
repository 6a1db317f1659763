#pragma once
// Which scans become keyframes: FRAME's selection by spaciousness, and now and then one on known ground. Pure: no
// clock, no I/O.

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

/// A step of exactly a threshold counts, whatever the rounding.
inline constexpr double step_rounding = 1e-9;

struct KeyframeConfig {
  float smoothing = 0.9F;                   // the weight of s_{k-1} in s_k = 0.9 s_{k-1} + 0.1 S_k
  double rotation_rad = 0.523598775598299;  // 30 deg
  double least_threshold_m = 0.5;           // a lidar that is covered or in a shaft must not make every scan a keyframe
  double known_after_m = 95;    // of path: what was seen before that is known ground, and drift has grown since
  double known_spacing_m = 20;  // of path between keyframes on known ground
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

  /// Decides on one scan. The first is a keyframe. Later ones are when
  /// - no earlier keyframe (the last one included) is nearer than the threshold, or
  /// - the sensor turned by rotation_rad or more since the last keyframe, and no keyframe nearer than the threshold
  /// looks
  ///   the same way (within less than rotation_rad), or
  /// - the path has grown by known_spacing_m since the last keyframe, and by known_after_m since every keyframe nearer
  /// than
  ///   the threshold. That is a deviation from the paper, which sends nothing of known ground: without it the server
  ///   could not see where the path of a robot that comes round again closes a loop.
  /// The path counts steps of 1 m and more, so that a robot at rest whose pose trembles drives nowhere.
  /// A mean range that is not finite and positive (an empty scan) leaves the spaciousness as it was. A pose that is not
  /// finite or farther than 1e9 m from the origin is never a keyframe.
  Decision add(const Pose& T_local_sensor, float mean_range_m);

  /// A keyframe that was chosen before a restart, in order: afterwards add() decides as if there had been none. The
  /// pose must be finite and within 1e9 m.
  void restore(const Pose& T_local_sensor, float spaciousness_m);

  /// How many keyframes were chosen or restored.
  std::size_t size() const { return keyframes_.size(); }

  /// Keyframes lie elsewhere now, by their numbers, 1 being the first that was chosen: afterwards add() decides as if
  /// all had been restored where they lie now. spaciousness_m: of the last keyframe. Throws std::out_of_range where a
  /// number is none. Costs what is moved, and an addition for each keyframe.
  void move(std::span<const KeyframePose> moved, float spaciousness_m);

 private:
  struct Nearby {
    bool any = false;       // an earlier keyframe is nearer than the threshold
    bool same_way = false;  // and one of those looks the same way
    bool lately = false;    // and one of those was seen less than known_after_m of path ago
  };
  struct Chosen {
    Pose T_local_sensor;
    double path_m = 0;  // driven until then
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
