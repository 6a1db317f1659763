#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/cloud/point_cloud.hpp"

namespace headframe {

struct Neighbour {
  std::uint32_t index = 0;
  float squared_m = 0;
};

/// Nearest neighbours in a fixed cloud. Keeps a copy of the points in leaf order. Ties go to the lower index, so
/// results do not depend on how the tree was cut. Queries are thread safe.
class KdTree {
 public:
  KdTree() = default;
  explicit KdTree(const Points& points);

  /// The nearest point strictly nearer than reach_m; false when there is none.
  bool nearest(const Eigen::Vector3f& query, float reach_m, Neighbour& out) const;

  /// The k nearest, nearest first (fewer when the cloud has fewer).
  void nearest_k(const Eigen::Vector3f& query, std::size_t k, std::vector<Neighbour>& out) const;

 private:
  struct Node {
    float split = 0;
    std::int32_t axis = -1;            // -1: a leaf
    std::uint32_t begin = 0, end = 0;  // of a leaf's points
    std::uint32_t right = 0;           // the left child follows its parent
  };
  std::uint32_t build(std::uint32_t begin, std::uint32_t end, const Points& points);
  template <class Visit>
  void search(const Eigen::Vector3f& query, float& reach_squared, Visit&& visit) const;

  std::vector<Node> nodes_;
  Points points_;
  std::vector<std::uint32_t> index_;
};

}  // namespace headframe
