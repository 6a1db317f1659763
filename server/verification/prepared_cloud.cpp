#include "server/verification/prepared_cloud.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "server/registration/kd_tree.hpp"
#include "server/registration/surfels.hpp"
#include "server/support/wide.hpp"

namespace headframe {
namespace {

constexpr float view_reach_m = 20;
constexpr std::size_t normal_neighbours = 12;

// Limits, above what a robot sends: a lidar of 128 beams and 1024 columns has as many points, and robots thin their
// clouds; a keyframe holds 17 sweeps within some metres. Of more points every n-th is used, of more sweeps the last,
// which include the keyframe's own.
constexpr std::size_t most_points = 131072, most_sweeps = 64;
constexpr float farthest_origin_m = 200, farthest_point_m = 1000;

/// False for what is not finite, too.
bool within(const Eigen::Vector3f& p, float reach_m) { return p.squaredNorm() < reach_m * reach_m; }

/// The coordinates of points, so that distances of many are computed at once.
struct Coordinates {
  explicit Coordinates(const Points& points) : x(points.size()), y(points.size()), z(points.size()) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      x[i] = points[i].x();
      y[i] = points[i].y();
      z[i] = points[i].z();
    }
  }
  std::vector<float> x, y, z;
};

/// How many of the points from `begin` to `end` are less than the root of squared_m away from point i.
HEADFRAME_WIDE int count_near(const Coordinates& points, std::size_t i, float squared_m, std::size_t begin,
                              std::size_t end) {
  const float *x = points.x.data(), *y = points.y.data(), *z = points.z.data();
  const float px = x[i], py = y[i], pz = z[i];
  int found = 0;
  for (std::size_t j = begin; j < end; ++j) {
    const float dx = x[j] - px, dy = y[j] - py, dz = z[j] - pz;
    found += static_cast<int>(dx * dx + dy * dy + dz * dz < squared_m);
  }
  return found;
}

/// Whether so many of the points, itself among them, are near point i. Looks first among those just before and after it
/// in the cloud, which is coded so that they are mostly near.
bool has_near(const Coordinates& points, std::size_t i, float squared_m, int count) {
  for (const std::size_t beside : {8U, 64U, 1024U}) {
    const std::size_t begin = i - std::min(i, beside), end = std::min(points.x.size(), i + beside + 1);
    if (count_near(points, i, squared_m, begin, end) >= count) return true;
  }
  return count_near(points, i, squared_m, 0, points.x.size()) >= count;
}

/// Dust and stray returns stand alone: a point stays when three others of its sweep lie within 8 % of its range, or
/// 0.25 m (dynamic radius outlier removal: Charron, Phillips, Waslander, CRV 2018). Seen from the sweep's origin.
Points without_strays(const Points& points) {
  constexpr int companions = 3;
  constexpr float least_reach_m = 0.25F, reach_share = 0.08F;
  constexpr std::size_t tree_from = 256;  // points that no others are near to: faster with a tree
  const Coordinates all(points);
  std::optional<KdTree> tree;
  std::size_t asked_all = 0;
  Points kept;
  kept.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float reach_m = std::max(least_reach_m, reach_share * points[i].norm());
    bool stays = false;
    if (tree) {
      stays = tree->has_within(points[i], reach_m, companions + 1);
    } else {
      stays = has_near(all, i, reach_m * reach_m, companions + 1);
      if (!stays && ++asked_all == tree_from) tree.emplace(points);
    }
    if (stays) kept.push_back(points[i]);
  }
  return kept;
}

/// Removes what the other sweeps of the keyframe see through; there are no normals yet. A point that only one sweep hit
/// stays, because the others may be where they could not hit it; the submap checks again with the sweeps of
/// neighbouring keyframes (free_space).
Points without_transients(const Points& points, const std::vector<PreparedCloud::View>& views) {
  Points kept;
  kept.reserve(points.size());
  std::array<Sight, SightBlock::most> sights;
  for (std::size_t first = 0; first < points.size(); first += SightBlock::most) {
    const auto some = std::span(points).subspan(first, std::min(SightBlock::most, points.size() - first));
    std::array<int, SightBlock::most> through{}, hits{};
    for (const auto& view : views) {
      SightBlock block;
      for (const Eigen::Vector3f& p : some) block.add(p - view.origin);
      view.image.look(block, view_reach_m, sights);
      for (std::size_t i = 0; i < some.size(); ++i) {
        through[i] += static_cast<int>(sights[i] == Sight::through);
        hits[i] += static_cast<int>(sights[i] == Sight::hit);
      }
    }
    for (std::size_t i = 0; i < some.size(); ++i)
      if (!is_transient(hits[i], through[i], 0)) kept.push_back(some[i]);
  }
  return kept;
}

}  // namespace

std::size_t bytes_of(const SurfelCloud& submap) {
  return (submap.points.capacity() + submap.normals.capacity()) * sizeof(Eigen::Vector3f);
}

std::size_t bytes_of(const PreparedCloud& cloud) {
  std::size_t bytes = (cloud.points.capacity() + cloud.normals.capacity()) * sizeof(Eigen::Vector3f);
  for (const PreparedCloud::View& view : *cloud.views) bytes += view.image.bytes();
  return bytes;
}

PreparedCloud prepare(const KeyframeCloud& cloud, int threads) {
  PreparedCloud out;
  Points all;
  std::vector<PreparedCloud::View> views;
  const std::size_t first = cloud.sweeps.size() - std::min(cloud.sweeps.size(), most_sweeps);
  const std::size_t step = 1 + point_count(cloud) / (most_points + 1);
  for (const Sweep& sweep : std::span(cloud.sweeps).subspan(first)) {
    if (!within(sweep.origin, farthest_origin_m)) continue;
    Points seen_from_origin;
    for (std::size_t i = 0; i < sweep.points.size(); i += step)
      if (within(sweep.points[i], farthest_point_m)) seen_from_origin.push_back(sweep.points[i] - sweep.origin);
    seen_from_origin = without_strays(seen_from_origin);
    for (const auto& p : seen_from_origin) all.push_back(p + sweep.origin);
    views.push_back({sweep.origin, SightImage(seen_from_origin)});
  }
  Surfels surfels =
      make_surfels(without_transients(voxel_grid(all, prepared_leaf_m), views), normal_neighbours, threads);
  out.points = std::move(surfels.points);
  out.normals = std::move(surfels.normals);
  out.views = std::make_shared<const std::vector<PreparedCloud::View>>(std::move(views));
  return out;
}

}  // namespace headframe
