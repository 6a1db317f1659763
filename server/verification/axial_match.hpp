#pragma once
// Surfaces that face along a tunnel: niches, corners, fronts. In a tunnel whose ribs or rings repeat, the walls fit at
// every period; only these tell one place of it from the next. Not to be asked where the walls hold nothing at all:
// single scan lines round the corners of a bare tunnel look like such surfaces, and lie where the robot stood.

#include <span>

#include "server/registration/vgicp.hpp"

namespace headframe {

/// b's points that face within 60 deg of an axis of a's, at T_a_b, ready to be slid along it.
class AxialSurfaces {
 public:
  /// axis_a: unit, in a's frame. Pairs are not owned and must outlive this.
  AxialSurfaces(std::span<const VgicpPair> pairs, const Pose& T_a_b, const Eigen::Vector3d& axis_a);

  /// Share of them, 0 to 1, that after a slide along the axis meet a surface of a that faces along it too, within about
  /// 0.15 m. Of a hundred at least: few prove nothing.
  double match(double slide_m) const;

  /// The slide within reach_m of here that matches best, if it matches clearly better than here; else 0.
  double best_slide_m(double reach_m) const;

 private:
  struct Point {
    const VoxelMap* target;
    Eigen::Vector3f p, normal;
  };
  std::vector<Point> points_;
  Eigen::Vector3f axis_;
};

}  // namespace headframe
