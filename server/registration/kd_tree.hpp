#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "server/support/simd.hpp"

namespace headframe {

struct Neighbour {
  std::uint32_t index = 0;
  float squared_m = 0;
};

/// x, y, z, and an unused lane that is 0.
struct Box {
  Float4 low, high;
};

/// Squared distance between the nearest points of two boxes; 0 if they touch or overlap.
inline float squared_gap(const Box& a, const Box& b) {
  const Float4 d = larger(larger(a.low - b.high, b.low - a.high), Float4{});
  return sum_of_lanes(d * d);
}

/// Nearest neighbours in a fixed cloud. Keeps a copy of the points, sixteen in each leaf. Of equally near points the
/// one with the lower index is chosen, so results do not depend on how the tree was built. Points that are not finite
/// are never found. Queries are thread safe.
class KdTree {
 public:
  static constexpr std::size_t leaf_points = 16;
  static constexpr std::size_t leaf_groups = leaf_points / 4;
  static constexpr float far_away = 1e18F;  // coordinate of an empty slot; its square still fits a float

  struct Leaf {
    std::array<Float4, leaf_groups> x, y, z;
    std::array<std::uint32_t, leaf_points> index;  // `nobody` in an empty slot
    Box box;
  };
  static constexpr std::uint32_t nobody = 0xFFFFFFFF;

  KdTree() = default;
  explicit KdTree(const Points& points, int threads = 1);

  /// The nearest point strictly nearer than reach_m; false if there is none.
  bool nearest(const Eigen::Vector3f& query, float reach_m, Neighbour& out) const;

  /// Replaces `best` by the nearest point if that is nearer, or equally near with a lower index.
  void improve(const Eigen::Vector3f& query, Neighbour& best) const;

  /// The k nearest points, nearest first (fewer if the cloud has fewer). If more than k points coincide with the query,
  /// any k of them.
  void nearest_k(const Eigen::Vector3f& query, std::size_t k, std::vector<Neighbour>& out) const;

  /// Whether at least `count` points lie nearer than reach_m; stops as soon as this is known.
  bool has_within(const Eigen::Vector3f& query, float reach_m, std::size_t count) const;

  /// Leaves in tree order: those near in the list are often near in space.
  const std::vector<Leaf>& leaves() const { return leaves_; }

  /// Appends, in ascending order, the numbers of the leaves whose boxes are within reach of `box`.
  void leaves_near(const Box& box, float squared_reach, std::vector<std::uint32_t>& out) const;

  /// Removes all points for which new_index holds `nobody`, and renumbers the others; new_index has an entry for every
  /// point that the tree was built from.
  void renumber(const std::vector<std::uint32_t>& new_index);

 private:
  struct Node {
    Box box;
    float split = 0;
    std::uint32_t right = 0;         // the left child follows its parent; 0: a leaf
    std::uint32_t axis_or_leaf = 0;  // the split axis, or the number of the leaf
  };
  struct Entry {
    Eigen::Vector3f p;
    std::uint32_t index;
  };
  void build(std::uint32_t node, std::size_t first_leaf, std::size_t leaf_count, std::vector<Entry>& entries,
             int threads);
  static Box box_of(const Entry* begin, const Entry* end);
  static void fill(Leaf& leaf, const Entry* begin, const Entry* end);
  template <class Visit>
  void search(const Eigen::Vector3f& query, const float& reach_squared, Visit&& visit) const;

  std::vector<Node> nodes_;
  std::vector<Leaf> leaves_;
};

}  // namespace headframe
