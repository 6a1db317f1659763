#pragma once

#include <array>
#include <vector>

#include "server/registration/kd_tree.hpp"
#include "server/registration/normal_equations.hpp"

namespace headframe {

/// The spatial distribution of the points around a point.
struct Neighbourhood {
  float count = 0;        // number of neighbours, including the point itself
  Symmetric3f scatter{};  // sum of (p - mean) (p - mean)^T, m^2
};

/// Finds the k nearest neighbours of all sixteen points of a leaf together, so that nearby leaves are looked up only
/// once. Includes all neighbours as near as the k-th, so the result does not depend on an order. Reuses its buffers:
/// use one object for each thread.
class NeighbourhoodFinder {
 public:
  NeighbourhoodFinder(const KdTree& tree, std::size_t k) : tree_(tree), k_(static_cast<int>(k)) {}

  /// One result for each slot of the leaf; count is 0 for empty slots.
  std::array<Neighbourhood, KdTree::leaf_points> find(std::size_t leaf);

 private:
  struct Group {
    Float4 dx, dy, dz;  // from the query
  };
  float first_bound(std::size_t leaf, const Eigen::Vector3f& query);
  bool gather(const KdTree::Leaf& leaf, const Eigen::Vector3f& query, float& bound);
  float kth_squared(float bound, int slack = 0) const;
  Neighbourhood moments(float bound) const;

  const KdTree& tree_;
  int k_;
  static constexpr std::size_t most_groups = 256;  // exceeded only if very many points are exactly as far as the k-th
  std::array<Group, most_groups> groups_;
  std::array<Float4, most_groups> squared_m_;  // their distances from the query
  std::size_t group_count_ = 0;
  std::vector<std::uint32_t> near_;
};

}  // namespace headframe
