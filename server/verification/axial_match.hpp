#pragma once
// Surfaces that face along a tunnel: niches, corners, end walls. In a tunnel with repeating ribs or rings the walls fit
// at every period; only these surfaces tell one position along it from the next. Meaningless if the walls do not hold
// the placement along the tunnel at all: single scan lines around the corners of a bare tunnel look like such surfaces,
// but lie wherever the robot stood.

#include <span>

#include "server/registration/vgicp.hpp"

namespace headframe {

/// Those of b's points that, at T_a_b, face within 60 deg of an axis in a's frame, ready to be slid along it.
class AxialSurfaces {
 public:
  /// axis_a: unit vector in a's frame. The data that the pairs point to is not owned and must outlive this object.
  AxialSurfaces(std::span<const VgicpPair> pairs, const Pose& T_a_b, const Eigen::Vector3d& axis_a);

  /// Share of the points, 0 to 1, that after a slide along the axis lie within about 0.15 m of a surface of a that
  /// faces along the axis too. With fewer than 100 points it is a share of 100, because few points prove nothing.
  double match(double slide_m) const;

  /// The slide of at most reach_m that matches best, if it matches clearly better than no slide; else 0.
  /// The same whatever the number of threads.
  double best_slide_m(double reach_m, int threads = 1) const;

 private:
  struct Surfaces {  // of one pair
    const VoxelMap* target;
    Points points, normals;
  };
  std::vector<Surfaces> surfaces_;
  std::size_t count_ = 0;
  Eigen::Vector3f axis_;
};

}  // namespace headframe
