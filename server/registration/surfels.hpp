#pragma once

#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "server/registration/kd_tree.hpp"

namespace headframe {

/// A cloud made ready for registration: points, the normal of the surface around each, and a tree. All in one frame.
struct Surfels {
  Points points;
  Points normals;  // unit; their sign carries no meaning
  KdTree tree;
  std::size_t size() const { return points.size(); }
};

/// Normals from the `neighbours` nearest points. Points whose surroundings are a line, a dot or too few are dropped:
/// they have no plane to hold on to. May end up empty. Surfels come in the order of the tree: neighbours in the list
/// are often neighbours in space. Independent of the number of threads.
Surfels make_surfels(const Points& points, std::size_t neighbours = 20, int threads = 1);

}  // namespace headframe
