#include "server/verification/change_patches.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <set>

#include "server/registration/kd_tree.hpp"

namespace headframe {
namespace {

// All set by hand, on the scenes of tests/scenario/changes_test and the placements of one set of made worlds.
constexpr float joined_m = 1.5F;  // greatest distance of two patches that count as one, seen from two places
constexpr float link_leaves = 2, fringe_leaves = 4;  // greatest distance between points of one patch, in leaves
constexpr float least_m2 = 2.5F;                     // of a patch
constexpr float most_length_m = 25;  // a machine, a tunnel face, a slashed wall; longer ones are contradictions
constexpr float ring_m = 4;          // around a patch, where both have to agree
constexpr std::size_t least_around = 12, least_beyond = 3;
constexpr double least_dense = 0.5;          // share of violations among the points of a patch that are not unknown ...
constexpr double most_around = 0.15;         // ... and around it
constexpr std::size_t most_violated = 3000;  // of one rock: the search for patches is quadratic in it

constexpr std::size_t most_changes = 3;  // between two sessions; a wrong placement has some at every place

/// Groups of points that are connected within reach, the group with the lowest index first.
std::vector<Points> groups(const Points& points, float reach_m) {
  std::vector<std::size_t> open;
  std::vector<bool> taken(points.size(), false);
  std::vector<Points> out;
  for (std::size_t first = 0; first < points.size(); ++first) {
    if (taken[first]) continue;
    Points& found = out.emplace_back();
    taken[first] = true;
    open.push_back(first);
    while (!open.empty()) {
      const Eigen::Vector3f& p = points[open.back()];
      open.pop_back();
      found.push_back(p);
      for (std::size_t i = first + 1; i < points.size(); ++i)
        if (!taken[i] && (points[i] - p).squaredNorm() < reach_m * reach_m) {
          taken[i] = true;
          open.push_back(i);
        }
    }
  }
  return out;
}

/// The points' mean and principal axes, as columns, the longest last.
struct Axes {
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();
  Eigen::Matrix3f axes = Eigen::Matrix3f::Identity();
  Eigen::Vector3f low = Eigen::Vector3f::Zero(), high = Eigen::Vector3f::Zero();  // along them, from the middle

  explicit Axes(const Points& points) {
    for (const auto& p : points) middle += p / static_cast<float>(points.size());
    Eigen::Matrix3f scatter = Eigen::Matrix3f::Zero();
    for (const auto& p : points) scatter += (p - middle) * (p - middle).transpose();
    axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f>(scatter).eigenvectors();
    for (const auto& p : points) {
      const Eigen::Vector3f q = along(p);
      low = low.cwiseMin(q);
      high = high.cwiseMax(q);
    }
  }
  Eigen::Vector3f along(const Eigen::Vector3f& p) const { return axes.transpose() * (p - middle); }
};

/// How many points on which both agree lie beyond the ends of a patch, along each of its axes.
struct Beyond {
  std::array<std::size_t, 3> below{}, above{};
};

Beyond beyond(const Axes& axes, const Points& agreed, float margin_m) {
  Beyond out;
  for (const auto& p : agreed) {
    const Eigen::Vector3f q = axes.along(p);
    for (int k = 0; k < 3; ++k) {
      out.below[static_cast<std::size_t>(k)] += q[k] < axes.low[k] - margin_m;
      out.above[static_cast<std::size_t>(k)] += q[k] > axes.high[k] + margin_m;
    }
  }
  return out;
}

struct Surroundings {
  std::size_t dense = 0, said = 0;      // of its own rock, on the patch: violated; violated or seen
  std::size_t against = 0, around = 0;  // in the ring: violated; violated or seen
  Points agreed;                        // of either rock, in the ring
};

Surroundings surroundings_of(const KdTree& patch, const AskedRock& own, const AskedRock& other, float link_m) {
  Surroundings out;
  Neighbour nearest;
  for (std::size_t i = 0; i < own.points.size(); ++i) {
    const bool against = own.sights[i] == PointSight::violated, agrees = own.sights[i] == PointSight::seen;
    if ((!against && !agrees) || !patch.nearest(own.points[i], link_m + ring_m, nearest)) continue;
    if (nearest.squared_m < link_m * link_m / 4) {
      out.said += 1;
      out.dense += against;
      continue;
    }
    out.around += 1;
    out.against += against;
    if (agrees) out.agreed.push_back(own.points[i]);
  }
  for (std::size_t i = 0; i < other.points.size(); ++i)
    if (other.sights[i] == PointSight::seen && patch.nearest(other.points[i], link_m + ring_m, nearest))
      out.agreed.push_back(other.points[i]);
  return out;
}

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

/// Whether it is compact and dense, and has an edge.
bool is_patch(const Points& points, const AskedRock& own, const AskedRock& other, float leaf_m, bool& free_standing) {
  const Axes axes(points);
  if (static_cast<float>(points.size()) * leaf_m * leaf_m < least_m2 || axes.high[2] - axes.low[2] > most_length_m)
    return false;
  const Surroundings s = surroundings_of(KdTree(points), own, other, link_leaves * leaf_m);
  if (share(s.dense, s.said) < least_dense || share(s.against, s.around) > most_around ||
      s.agreed.size() < least_around)
    return false;
  const Beyond past = beyond(axes, s.agreed, 0);
  constexpr std::size_t across = 0, second = 1, longest = 2;
  free_standing = past.below[across] >= least_beyond && past.above[across] >= least_beyond;
  const bool ends = past.below[longest] >= least_beyond && past.above[longest] >= least_beyond;
  const bool sides = past.below[second] >= least_beyond || past.above[second] >= least_beyond;
  return ends && sides;
}

bool touch(const Points& some, const Points& others, float reach_m) {
  const KdTree tree(some);
  Neighbour nearest;
  return std::any_of(others.begin(), others.end(), [&](const auto& p) { return tree.nearest(p, reach_m, nearest); });
}

void add_patches(const AskedRock& own, const AskedRock& other, float leaf_m, const ChangePatch& like,
                 std::vector<ChangePatch>& out) {
  Points violated;
  for (std::size_t i = 0; i < own.points.size(); ++i)
    if (own.sights[i] == PointSight::violated) violated.push_back(own.points[i]);
  if (violated.size() > most_violated) return;
  std::vector<Points> rest;
  const std::size_t first = out.size();
  for (Points& points : groups(violated, link_leaves * leaf_m)) {
    ChangePatch patch = like;
    patch.points = std::move(points);
    if (is_patch(patch.points, own, other, leaf_m, patch.free_standing))
      out.push_back(std::move(patch));
    else
      rest.push_back(std::move(patch.points));
  }
  for (const Points& few : rest)  // at the edge of a patch some of it is hidden
    for (std::size_t i = first; i < out.size(); ++i) {
      if (!touch(out[i].points, few, fringe_leaves * leaf_m)) continue;
      out[i].points.insert(out[i].points.end(), few.begin(), few.end());
      break;
    }
}

/// Horizontal lengths along the two principal axes of the points, the longer first, and the vertical one.
Eigen::Vector3d size_m(const Points& points) {
  Points level = points;
  for (auto& p : level) p.z() = 0;
  const Axes axes(level);  // the first axis is vertical, as nothing varies along it
  const auto [low, high] =
      std::minmax_element(points.begin(), points.end(), [](const auto& p, const auto& q) { return p.z() < q.z(); });
  return Eigen::Vector3f(axes.high[2] - axes.low[2], axes.high[1] - axes.low[1], high->z() - low->z()).cast<double>();
}

}  // namespace

std::string_view to_string(ChangeKind kind) { return kind == ChangeKind::excavated ? "excavated" : "filled"; }

Change seen_from_b(Change change, const Pose& T_a_b) {
  change.p_a = T_a_b.inverse() * change.p_a;
  change.a_is_newer = !change.a_is_newer;
  return change;
}

std::optional<Dates> dates_of(const Recorded& a, const Recorded& b) {
  if (gap_s(a, b) < least_gap_s) return std::nullopt;
  return a.from_s > b.to_s ? Dates{true, b.to_s, a.from_s} : Dates{false, a.to_s, b.from_s};
}

std::vector<ChangePatch> find_patches(const AskedRock& a, const AskedRock& b, float leaf_m, const Dates& dates) {
  const auto kind = [&](bool newer) { return newer ? ChangeKind::filled : ChangeKind::excavated; };
  std::vector<ChangePatch> out;
  add_patches(a, b, leaf_m, {{}, kind(dates.a_is_newer), false, dates}, out);
  add_patches(b, a, leaf_m, {{}, kind(!dates.a_is_newer), false, dates}, out);
  return out;
}

std::vector<ChangePatch> joined(std::vector<ChangePatch> patches) {
  for (std::size_t i = 0; i < patches.size(); ++i)
    for (std::size_t k = i + 1; k < patches.size();) {
      ChangePatch &one = patches[i], &other = patches[k];
      if (one.kind != other.kind || one.dates.a_is_newer != other.dates.a_is_newer ||
          !touch(one.points, other.points, joined_m)) {
        ++k;
        continue;
      }
      one.free_standing = one.free_standing && other.free_standing;
      one.points.insert(one.points.end(), other.points.begin(), other.points.end());
      one.dates.older_s = std::max(one.dates.older_s, other.dates.older_s);
      one.dates.newer_s = std::min(one.dates.newer_s, other.dates.newer_s);
      patches.erase(patches.begin() + static_cast<std::ptrdiff_t>(k));
      k = i + 1;  // the larger patch may touch others that it did not touch before
    }
  return patches;
}

bool plausible(std::span<const ChangePatch> changes) {
  std::set<ChangeKind> of_walls;
  for (const ChangePatch& change : changes)
    if (!change.free_standing) of_walls.insert(change.kind);
  return changes.size() <= most_changes && of_walls.size() < 2;
}

Change change_of(const ChangePatch& patch) {
  const Eigen::Vector3d size = size_m(patch.points);
  return {patch.kind,
          Axes(patch.points).middle.cast<double>(),
          size.x(),
          size.y(),
          size.z(),
          patch.dates.a_is_newer,
          patch.dates.older_s,
          patch.dates.newer_s};
}

}  // namespace headframe
