#include "server/registration/kd_tree.hpp"

#include <algorithm>
#include <limits>

#include "server/support/parallel.hpp"

namespace headframe {
namespace {

constexpr std::size_t leaves_worth_a_thread = 64;

bool nearer(const Neighbour& a, const Neighbour& b) {
  return a.squared_m < b.squared_m || (a.squared_m == b.squared_m && a.index < b.index);
}

Float4 squared_distances(const KdTree::Leaf& leaf, std::size_t group, const Eigen::Vector3f& q) {
  const Float4 dx = leaf.x[group] - q.x(), dy = leaf.y[group] - q.y(), dz = leaf.z[group] - q.z();
  return dx * dx + dy * dy + dz * dz;
}

}  // namespace

KdTree::KdTree(const Points& points, int threads) {
  std::vector<Entry> entries;
  entries.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i)
    if (points[i].allFinite() && points[i].cwiseAbs().maxCoeff() < 0.1F * far_away) entries.push_back({points[i], i});
  leaves_.resize((entries.size() + leaf_points - 1) / leaf_points);
  if (leaves_.empty()) return;
  nodes_.resize(2 * leaves_.size() - 1);
  build(0, 0, leaves_.size(), entries, threads);
}

Box KdTree::box_of(const Entry* begin, const Entry* end) {
  const auto lanes = [](const Entry& e) { return Float4{e.p.x(), e.p.y(), e.p.z(), 0}; };
  Box box{lanes(*begin), lanes(*begin)};
  for (const Entry* e = begin; e != end; ++e) {
    box.low = -larger(-box.low, -lanes(*e));
    box.high = larger(box.high, lanes(*e));
  }
  return box;
}

/// Builds a subtree over consecutive leaves, which are all full except the cloud's last. So the positions of its nodes
/// are known in advance, and both halves can be built in parallel.
void KdTree::build(std::uint32_t node, std::size_t first_leaf, std::size_t leaf_count, std::vector<Entry>& entries,
                   int threads) {
  Entry* begin = entries.data() + first_leaf * leaf_points;
  Entry* end = entries.data() + std::min(entries.size(), (first_leaf + leaf_count) * leaf_points);
  const Box box = box_of(begin, end);
  nodes_[node].box = box;
  if (leaf_count == 1) {
    nodes_[node].axis_or_leaf = static_cast<std::uint32_t>(first_leaf);
    leaves_[first_leaf].box = box;
    fill(leaves_[first_leaf], begin, end);
    return;
  }
  const Float4 size = box.high - box.low;
  const Eigen::Index axis = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
  const std::size_t left = leaf_count - leaf_count / 2;
  std::nth_element(begin, begin + left * leaf_points, end, [axis](const Entry& a, const Entry& b) {
    return a.p[axis] < b.p[axis] || (a.p[axis] == b.p[axis] && a.index < b.index);
  });
  const auto right = static_cast<std::uint32_t>(node + 2 * left);
  nodes_[node].right = right;
  nodes_[node].axis_or_leaf = static_cast<std::uint32_t>(axis);
  nodes_[node].split = begin[left * leaf_points].p[axis];
  for_blocks(2, 1, leaf_count < leaves_worth_a_thread ? 1 : threads, [&](std::size_t half, std::size_t, std::size_t) {
    if (half == 0)
      build(node + 1, first_leaf, left, entries, threads);
    else
      build(right, first_leaf + left, leaf_count - left, entries, threads);
  });
}

void KdTree::fill(Leaf& leaf, const Entry* begin, const Entry* end) {
  leaf.x.fill(all_lanes(far_away));
  leaf.y = leaf.z = leaf.x;
  leaf.index.fill(nobody);
  for (std::size_t i = 0; begin + i != end; ++i) {
    leaf.x[i / 4][i % 4] = begin[i].p.x();
    leaf.y[i / 4][i % 4] = begin[i].p.y();
    leaf.z[i / 4][i % 4] = begin[i].p.z();
    leaf.index[i] = begin[i].index;
  }
}

template <class Visit>
void KdTree::search(const Eigen::Vector3f& query, const float& reach_squared, Visit&& visit) const {
  if (nodes_.empty()) return;
  struct Pending {
    std::uint32_t node;
    float squared_m;
  };
  std::array<Pending, 64> stack;  // a balanced tree over 2^32 points is 28 deep
  std::size_t top = 0;
  stack[top++] = {0, 0};
  while (top > 0) {
    const Pending pending = stack[--top];
    if (pending.squared_m > reach_squared) continue;
    std::uint32_t at = pending.node;
    while (nodes_[at].right != 0) {
      const Node& node = nodes_[at];
      const float d = query[node.axis_or_leaf] - node.split;
      const std::uint32_t near = d < 0 ? at + 1 : node.right;
      const std::uint32_t far = d < 0 ? node.right : at + 1;
      if (d * d <= reach_squared) stack[top++] = {far, d * d};
      at = near;
    }
    const Leaf& leaf = leaves_[nodes_[at].axis_or_leaf];
    for (std::size_t g = 0; g < leaf_groups; ++g) {
      const Float4 squared_m = squared_distances(leaf, g, query);
      if (!any(squared_m <= reach_squared)) continue;
      for (std::size_t i = 0; i < 4; ++i) visit(Neighbour{leaf.index[4 * g + i], squared_m[i]});
    }
  }
}

void KdTree::improve(const Eigen::Vector3f& query, Neighbour& best) const {
  search(query, best.squared_m, [&](const Neighbour& n) {
    if (nearer(n, best)) best = n;
  });
}

bool KdTree::nearest(const Eigen::Vector3f& query, float reach_m, Neighbour& out) const {
  Neighbour best{nobody, reach_m * reach_m};
  improve(query, best);
  if (best.index == nobody || best.squared_m >= reach_m * reach_m) return false;
  out = best;
  return true;
}

void KdTree::nearest_k(const Eigen::Vector3f& query, std::size_t k, std::vector<Neighbour>& out) const {
  out.clear();
  if (k == 0) return;
  float reach_squared = std::numeric_limits<float>::max();
  search(query, reach_squared, [&](const Neighbour& n) {
    if (n.index == nobody || (out.size() == k && !nearer(n, out.back()))) return;
    if (out.size() == k) out.pop_back();
    out.insert(std::upper_bound(out.begin(), out.end(), n, nearer), n);
    if (out.size() < k) return;
    const float farthest = out.back().squared_m;
    reach_squared = farthest > 0 ? farthest : -1;  // nothing can be nearer: of coinciding points not all are visited
  });
}

bool KdTree::has_within(const Eigen::Vector3f& query, float reach_m, std::size_t count) const {
  const float squared_m = reach_m * reach_m;
  float reach_squared = squared_m;
  std::size_t found = 0;
  search(query, reach_squared, [&](const Neighbour& n) {
    if (n.index == nobody || n.squared_m >= squared_m || ++found < count) return;
    reach_squared = -1;  // enough were found
  });
  return found >= count;
}

void KdTree::leaves_near(const Box& box, float squared_reach, std::vector<std::uint32_t>& out) const {
  if (nodes_.empty()) return;
  std::array<std::uint32_t, 64> stack;
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const std::uint32_t at = stack[--top];
    const Node& node = nodes_[at];
    if (squared_gap(node.box, box) > squared_reach) continue;
    if (node.right == 0) {
      out.push_back(node.axis_or_leaf);
    } else {
      stack[top++] = node.right;
      stack[top++] = at + 1;
    }
  }
}

void KdTree::renumber(const std::vector<std::uint32_t>& new_index) {
  for (Leaf& leaf : leaves_)
    for (std::size_t i = 0; i < leaf_points; ++i) {
      if (leaf.index[i] == nobody) continue;
      leaf.index[i] = new_index[leaf.index[i]];
      if (leaf.index[i] == nobody) leaf.x[i / 4][i % 4] = leaf.y[i / 4][i % 4] = leaf.z[i / 4][i % 4] = far_away;
    }
}

}  // namespace headframe
