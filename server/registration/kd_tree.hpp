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

/// x, y, z, and a lane that is 0.
struct Box {
  Float4 low, high;
};

/// Squared distance between the nearest points of two boxes; 0 where they meet.
inline float squared_gap(const Box& a, const Box& b) {
  const Float4 d = larger(larger(a.low - b.high, b.low - a.high), Float4{});
  return sum_of_lanes(d * d);
}

/// Nearest neighbours in a fixed cloud. Keeps a copy of the points, sixteen to a leaf. Ties go to the lower index, so
/// results do not depend on how the tree was cut. Points that are not finite are never found. Queries are thread safe.
class KdTree {
 public:
  static constexpr std::size_t leaf_points = 16;
  static constexpr std::size_t leaf_groups = leaf_points / 4;
  static constexpr float far_away = 1e18F;  // coordinate of an empty place; its square is still a float

  struct Leaf {
    std::array<Float4, leaf_groups> x, y, z;
    std::array<std::uint32_t, leaf_points> index;  // `nobody` in an empty place
    Box box;
  };
  static constexpr std::uint32_t nobody = 0xFFFFFFFF;

  KdTree() = default;
  explicit KdTree(const Points& points, int threads = 1);

  /// The nearest point strictly nearer than reach_m; false when there is none.
  bool nearest(const Eigen::Vector3f& query, float reach_m, Neighbour& out) const;

  /// Puts the nearest point into `best` if it is nearer, or as near and of a lower index.
  void improve(const Eigen::Vector3f& query, Neighbour& best) const;

  /// The k nearest, nearest first (fewer when the cloud has fewer). Of more than k points at the very place of the
  /// query it gives any k.
  void nearest_k(const Eigen::Vector3f& query, std::size_t k, std::vector<Neighbour>& out) const;

  /// Whether so many points lie nearer than reach_m: it looks at no more than it needs to say so.
  bool has_within(const Eigen::Vector3f& query, float reach_m, std::size_t count) const;

  /// Leaves in the order of the tree: those near in the list are often near in space.
  const std::vector<Leaf>& leaves() const { return leaves_; }

  /// Appends the numbers of the leaves whose boxes lie within the reach of `box`, in ascending order.
  void leaves_near(const Box& box, float squared_reach, std::vector<std::uint32_t>& out) const;

  /// Forgets all points but those that new_index gives a number (others: nobody); new_index has an entry for every
  /// point the tree was made of.
  void renumber(const std::vector<std::uint32_t>& new_index);

 private:
  struct Node {
    Box box;
    float split = 0;
    std::uint32_t right = 0;         // the left child follows its parent; 0: a leaf
    std::uint32_t axis_or_leaf = 0;  // what is split, or which leaf it is
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
