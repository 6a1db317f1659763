#include "server/registration/kd_tree.hpp"

#include <algorithm>
#include <array>
#include <numeric>

namespace headframe {
namespace {

constexpr std::uint32_t leaf_points = 12;

bool nearer(const Neighbour& a, const Neighbour& b) {
  return a.squared_m < b.squared_m || (a.squared_m == b.squared_m && a.index < b.index);
}

}  // namespace

KdTree::KdTree(const Points& points) : index_(points.size()) {
  std::iota(index_.begin(), index_.end(), 0U);
  nodes_.reserve(2 * points.size() / leaf_points + 4);
  if (!points.empty()) build(0, static_cast<std::uint32_t>(points.size()), points);
  points_.reserve(points.size());
  for (std::uint32_t i : index_) points_.push_back(points[i]);
}

std::uint32_t KdTree::build(std::uint32_t begin, std::uint32_t end, const Points& points) {
  const auto id = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  if (end - begin <= leaf_points) {
    nodes_[id].begin = begin;
    nodes_[id].end = end;
    return id;
  }
  Eigen::Vector3f low = points[index_[begin]], high = low;
  for (std::uint32_t i = begin; i < end; ++i) {
    low = low.cwiseMin(points[index_[i]]);
    high = high.cwiseMax(points[index_[i]]);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(index_.begin() + begin, index_.begin() + middle, index_.begin() + end, [&](auto a, auto b) {
    return points[a][axis] < points[b][axis] || (points[a][axis] == points[b][axis] && a < b);
  });
  nodes_[id].axis = static_cast<std::int32_t>(axis);
  nodes_[id].split = points[index_[middle]][axis];
  build(begin, middle, points);
  const std::uint32_t right = build(middle, end, points);
  nodes_[id].right = right;
  return id;
}

template <class Visit>
void KdTree::search(const Eigen::Vector3f& query, float& reach_squared, Visit&& visit) const {
  if (nodes_.empty()) return;
  struct Pending {
    std::uint32_t node;
    float squared_m;
  };
  std::array<Pending, 64> stack;  // a balanced tree over 2^32 points is 29 deep
  std::size_t top = 0;
  stack[top++] = {0, 0};
  while (top > 0) {
    const Pending pending = stack[--top];
    if (pending.squared_m > reach_squared) continue;
    std::uint32_t at = pending.node;
    while (nodes_[at].axis >= 0) {
      const Node& node = nodes_[at];
      const float d = query[node.axis] - node.split;
      const std::uint32_t near = d < 0 ? at + 1 : node.right;
      const std::uint32_t far = d < 0 ? node.right : at + 1;
      if (d * d <= reach_squared) stack[top++] = {far, d * d};
      at = near;
    }
    for (std::uint32_t i = nodes_[at].begin; i < nodes_[at].end; ++i)
      visit(Neighbour{index_[i], (points_[i] - query).squaredNorm()});
  }
}

bool KdTree::nearest(const Eigen::Vector3f& query, float reach_m, Neighbour& out) const {
  float reach_squared = reach_m * reach_m;
  Neighbour best{std::numeric_limits<std::uint32_t>::max(), reach_squared};
  search(query, reach_squared, [&](const Neighbour& n) {
    if (!nearer(n, best)) return;
    best = n;
    reach_squared = n.squared_m;
  });
  if (best.index == std::numeric_limits<std::uint32_t>::max() || best.squared_m >= reach_m * reach_m) return false;
  out = best;
  return true;
}

void KdTree::nearest_k(const Eigen::Vector3f& query, std::size_t k, std::vector<Neighbour>& out) const {
  out.clear();
  if (k == 0) return;
  float reach_squared = std::numeric_limits<float>::max();
  search(query, reach_squared, [&](const Neighbour& n) {
    if (out.size() == k && !nearer(n, out.back())) return;
    if (out.size() == k) out.pop_back();
    out.insert(std::upper_bound(out.begin(), out.end(), n, nearer), n);
    if (out.size() == k) reach_squared = out.back().squared_m;
  });
}

}  // namespace headframe
