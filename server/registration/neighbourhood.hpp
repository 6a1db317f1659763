#pragma once

#include <array>
#include <vector>

#include "server/registration/kd_tree.hpp"
#include "server/registration/normal_equations.hpp"

namespace headframe {

/// How the points around a point are spread.
struct Neighbourhood {
  float count = 0;        // neighbours, the point itself among them
  Symmetric3f scatter{};  // sum of (p - mean) (p - mean)^T, m^2
};

/// Finds the k nearest of all points of a leaf together: what leaves are near is asked once for the sixteen. Neighbours
/// as far as the k-th are all taken, so nothing depends on an order. Keeps its buffers: one object a thread.
class NeighbourhoodFinder {
 public:
  NeighbourhoodFinder(const KdTree& tree, std::size_t k) : tree_(tree), k_(static_cast<int>(k)) {}

  /// Of the points of the leaf, by their place in it; count is 0 in empty places.
  std::array<Neighbourhood, KdTree::leaf_points> find(std::size_t leaf);

 private:
  struct Group {
    Float4 dx, dy, dz, squared_m;  // from the query
  };
  float first_bound(std::size_t leaf, const Eigen::Vector3f& query);
  bool gather(const KdTree::Leaf& leaf, const Eigen::Vector3f& query, float& bound);
  float kth_squared(float bound, int slack = 0) const;
  Neighbourhood moments(float bound) const;

  const KdTree& tree_;
  int k_;
  static constexpr std::size_t most_groups = 256;  // more only when very many points lie as far as the k-th
  std::array<Group, most_groups> groups_;
  std::size_t group_count_ = 0;
  std::vector<std::uint32_t> near_;
};

}  // namespace headframe
