#include "server/registration/neighbourhood.hpp"

#include <algorithm>
#include <span>

#include "server/support/wide.hpp"

namespace headframe {
namespace {

constexpr float unbounded = 0.01F * KdTree::far_away * KdTree::far_away;  // nearer than any empty slot
constexpr int loose = 8;                                                  // a first bound need not be tight

Eigen::Vector3f point_of(const KdTree::Leaf& leaf, std::size_t i) {
  return {leaf.x[i / 4][i % 4], leaf.y[i / 4][i % 4], leaf.z[i / 4][i % 4]};
}

/// How many of the numbers are not above `most`.
HEADFRAME_WIDE int count_up_to(std::span<const float> numbers, float most) {
  int found = 0;
  for (const float number : numbers) found += static_cast<int>(number <= most);
  return found;
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
    const Float4 place{query.x(), query.y(), query.z(), 0};
    const Box here{place, place};
    group_count_ = 0;
    for (const std::uint32_t n : near_)
      if (squared_gap(leaves[n].box, here) <= bounds[i] && !gather(leaves[n], query, bounds[i])) break;
    out[i] = moments(kth_squared(bounds[i]));
  }
  return out;
}

/// An upper bound of the squared distance to the k-th neighbour, from the next leaves in the tree, which hold enough
/// points.
float NeighbourhoodFinder::first_bound(std::size_t leaf, const Eigen::Vector3f& query) {
  const auto& leaves = tree_.leaves();
  const std::size_t wanted = static_cast<std::size_t>(k_) / KdTree::leaf_points + 2;
  const std::size_t begin = leaf - leaf % wanted, end = std::min(leaves.size(), begin + wanted);
  group_count_ = 0;
  float bound = unbounded;
  for (std::size_t n = begin; n < end; ++n) gather(leaves[n], query, bound);
  return kth_squared(bound, loose);
}

/// Keeps the groups of four that have a point within the bound. If the buffer is full, lowers the bound; if it is still
/// full, returns false and leaves points as far as the k-th out.
bool NeighbourhoodFinder::gather(const KdTree::Leaf& leaf, const Eigen::Vector3f& query, float& bound) {
  if (group_count_ + KdTree::leaf_groups > most_groups) {
    bound = kth_squared(bound);
    std::size_t kept = 0;
    for (std::size_t g = 0; g < group_count_; ++g) {
      groups_[kept] = groups_[g];
      squared_m_[kept] = squared_m_[g];
      kept += any(squared_m_[g] <= bound) ? 1 : 0;
    }
    group_count_ = kept;
    if (group_count_ + KdTree::leaf_groups > most_groups) return false;
  }
  for (std::size_t g = 0; g < KdTree::leaf_groups; ++g) {
    const Float4 dx = leaf.x[g] - query.x(), dy = leaf.y[g] - query.y(), dz = leaf.z[g] - query.z();
    const Float4 squared_m = dx * dx + dy * dy + dz * dz;
    groups_[group_count_] = {dx, dy, dz};
    squared_m_[group_count_] = squared_m;
    group_count_ += any(squared_m <= bound) ? 1 : 0;
  }
  return true;
}

/// A squared distance that k to k + slack points do not exceed, or more points if several are exactly as far as the
/// k-th; `bound` if no more than k + slack points are within it. Found by interpolation between counts, with bisection
/// steps if that is slow.
float NeighbourhoodFinder::kth_squared(float bound, int slack) const {
  const std::span distances(reinterpret_cast<const float*>(squared_m_.data()), 4 * group_count_);
  const auto count = [&](float squared_m) { return count_up_to(distances, squared_m); };
  float low = 0, high = bound;
  const int aim = k_ + slack / 2;
  int below = 0, above = count(high);
  if (above <= k_ + slack) return bound;
  if (high == unbounded) {
    Float4 farthest{};
    for (const Float4& d : std::span(squared_m_.data(), group_count_)) {
      const Float4 known = masked(d <= unbounded, d);
      farthest = larger(farthest, known);
    }
    high = std::max(std::max(farthest[0], farthest[1]), std::max(farthest[2], farthest[3]));
  }
  for (int i = 0; above > k_ + slack; ++i) {
    const float share = static_cast<float>(aim - below) / static_cast<float>(above - below);
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
  for (std::size_t i = 0; i < group_count_; ++i) {
    const Group& g = groups_[i];
    const Mask4 in = squared_m_[i] <= bound;
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
