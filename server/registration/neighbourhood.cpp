#include "server/registration/neighbourhood.hpp"

#include <algorithm>
#include <limits>

namespace headframe {
namespace {

constexpr float unbounded = 0.01F * KdTree::far_away * KdTree::far_away;  // nearer than any empty place
constexpr std::size_t most_groups = 256;  // of a query: more only when very many points lie as far as the k-th

Eigen::Vector3f point_of(const KdTree::Leaf& leaf, std::size_t i) {
  return {leaf.x[i / 4][i % 4], leaf.y[i / 4][i % 4], leaf.z[i / 4][i % 4]};
}

}  // namespace

std::array<Neighbourhood, KdTree::leaf_points> NeighbourhoodFinder::find(std::size_t leaf) {
  const auto& leaves = tree_.leaves();
  const KdTree::Leaf& own = leaves[leaf];
  std::array<float, KdTree::leaf_points> bounds{};
  float reach = 0;
  for (std::size_t i = 0; i < KdTree::leaf_points; ++i) {
    if (own.index[i] == KdTree::nobody) continue;
    bounds[i] = first_bound(leaf, point_of(own, i));
    reach = std::max(reach, bounds[i]);
  }
  near_.clear();
  tree_.leaves_near(own.box, reach, near_);
  std::array<Neighbourhood, KdTree::leaf_points> out;
  for (std::size_t i = 0; i < KdTree::leaf_points; ++i) {
    if (own.index[i] == KdTree::nobody) continue;
    const Eigen::Vector3f query = point_of(own, i);
    const Box here{query, query};
    groups_.clear();
    for (const std::uint32_t n : near_)
      if (squared_gap(leaves[n].box, here) <= bounds[i]) gather(leaves[n], query, bounds[i]);
    out[i] = moments(kth_squared(bounds[i]));
  }
  return out;
}

/// An upper bound of the squared distance to the k-th neighbour: among the leaves next in the tree, which hold enough.
float NeighbourhoodFinder::first_bound(std::size_t leaf, const Eigen::Vector3f& query) {
  const auto& leaves = tree_.leaves();
  const std::size_t wanted = static_cast<std::size_t>(k_) / KdTree::leaf_points + 2;
  const std::size_t begin = leaf - leaf % wanted, end = std::min(leaves.size(), begin + wanted);
  groups_.clear();
  float bound = unbounded;
  for (std::size_t n = begin; n < end; ++n) gather(leaves[n], query, bound);
  return kth_squared(bound);
}

/// Keeps the groups of four that have a point within the bound. Lowers the bound when there is no room left; points as
/// far as the k-th that find no room even then are left out.
void NeighbourhoodFinder::gather(const KdTree::Leaf& leaf, const Eigen::Vector3f& query, float& bound) {
  if (groups_.size() + KdTree::leaf_groups > most_groups) {
    bound = kth_squared(bound);
    std::erase_if(groups_, [&](const Group& g) { return !any(g.squared_m <= bound); });
    if (groups_.size() + KdTree::leaf_groups > most_groups) return;
  }
  for (std::size_t g = 0; g < KdTree::leaf_groups; ++g) {
    const Float4 dx = leaf.x[g] - query.x(), dy = leaf.y[g] - query.y(), dz = leaf.z[g] - query.z();
    const Float4 squared_m = dx * dx + dy * dy + dz * dz;
    if (any(squared_m <= bound)) groups_.push_back({dx, dy, dz, squared_m});
  }
}

/// Squared distance that k points, or more when several are as far as the k-th, do not exceed: the bound when it has no
/// more than k. Found by interpolation between counts, and by halving when that is slow.
float NeighbourhoodFinder::kth_squared(float bound) const {
  const auto count = [&](float squared_m) {
    Mask4 ones{};
    for (const Group& g : groups_) ones -= g.squared_m <= squared_m;
    return count_of_lanes(ones);
  };
  float low = 0, high = bound;
  int below = 0, above = count(high);
  if (above <= k_) return bound;
  if (high == unbounded) {
    Float4 farthest{};
    for (const Group& g : groups_) {
      const Float4 known = masked(g.squared_m <= unbounded, g.squared_m);
      farthest = known > farthest ? known : farthest;
    }
    high = std::max(std::max(farthest[0], farthest[1]), std::max(farthest[2], farthest[3]));
  }
  for (int i = 0; above > k_; ++i) {
    const float share = static_cast<float>(k_ - below) / static_cast<float>(above - below);
    float middle = low + (high - low) * (i % 3 == 2 ? 0.5F : share);
    if (!(middle > low && middle < high)) middle = low + (high - low) / 2;
    if (!(middle > low && middle < high)) break;  // ties
    const int n = count(middle);
    (n < k_ ? low : high) = middle;
    (n < k_ ? below : above) = n;
  }
  return high;
}

Neighbourhood NeighbourhoodFinder::moments(float bound) const {
  Float4 n{}, x{}, y{}, z{}, xx{}, xy{}, xz{}, yy{}, yz{}, zz{};
  for (const Group& g : groups_) {
    const Mask4 in = g.squared_m <= bound;
    const Float4 dx = masked(in, g.dx), dy = masked(in, g.dy), dz = masked(in, g.dz);
    n += masked(in, all_lanes(1));
    x += dx, y += dy, z += dz;
    xx += dx * dx, xy += dx * dy, xz += dx * dz, yy += dy * dy, yz += dy * dz, zz += dz * dz;
  }
  Neighbourhood out;
  out.count = sum_of_lanes(n);
  const float mx = sum_of_lanes(x) / out.count, my = sum_of_lanes(y) / out.count, mz = sum_of_lanes(z) / out.count;
  out.scatter = {sum_of_lanes(xx) - out.count * mx * mx, sum_of_lanes(xy) - out.count * mx * my,
                 sum_of_lanes(xz) - out.count * mx * mz, sum_of_lanes(yy) - out.count * my * my,
                 sum_of_lanes(yz) - out.count * my * mz, sum_of_lanes(zz) - out.count * mz * mz};
  return out;
}

}  // namespace headframe
