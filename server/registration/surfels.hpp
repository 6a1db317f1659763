#pragma once

#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "server/registration/kd_tree.hpp"

namespace headframe {

/// A cloud prepared for registration: points, the surface normal at each, and a tree. All in one frame.
struct Surfels {
  Points points;
  Points normals;  // unit length, arbitrary sign
  KdTree tree;
  std::size_t size() const { return points.size(); }
};

/// Computes normals from the `neighbours` nearest points. Drops points whose neighbours form a line or a dot, or are
/// too few: they define no plane. The result may be empty. Surfels are in the order of the tree, so neighbours in the
/// list are often neighbours in space. Independent of the number of threads.
Surfels make_surfels(const Points& points, std::size_t neighbours = 20, int threads = 1);

}  // namespace headframe
