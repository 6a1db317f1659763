#pragma once
// A mine of straight drifts, drawn by hand: the union of boxes is free space. Rays are exact, so tests have a truth.

#include <random>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/session/keyframe.hpp"

namespace headframe::test {

struct Box {
  Eigen::Vector3d low, high;
};

class BoxMine {
 public:
  explicit BoxMine(std::vector<Box> boxes) : boxes_(std::move(boxes)) {}

  /// A drift along the floor from (x0, y0) to (x1, y1), parallel to an axis.
  static Box drift(double x0, double y0, double x1, double y1, double width_m = 4, double height_m = 3);

  /// Distance from a point in free space to the wall.
  double range_m(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const;

  /// A scan of beams x columns over +-22.5 deg in the sensor frame, with Gaussian range noise. Up to 60 m.
  Points scan(const Pose& T_mine_sensor, std::mt19937& rng, double noise_m = 0.01, int beams = 32,
              int columns = 180) const;

 private:
  std::vector<Box> boxes_;
};

/// One robot's session: keyframes (with wall profile and Scan Context) and their clouds, in a frame W_n with its origin
/// at the first pose and turned by frame_yaw.
struct Drive {
  Pose T_mine_local = Pose::Identity();
  std::vector<Keyframe> keyframes;
  std::vector<KeyframeCloud> clouds;
};

/// Drives along the corners given (x, y), a keyframe every spacing_m, sensor 1.2 m above the floor.
Drive drive(const BoxMine& mine, const std::vector<Eigen::Vector2d>& corners, double frame_yaw_rad, unsigned seed,
            double spacing_m = 3);

}  // namespace headframe::test
