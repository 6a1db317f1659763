#include "server/verification/prepared_cloud.hpp"

#include <algorithm>
#include <optional>

#include "server/registration/kd_tree.hpp"
#include "server/registration/surfels.hpp"

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

/// Whether `count` of the points lie within reach of points[i], itself among them, as far as those tell that come just
/// before and after it in the cloud: it is coded so that these are mostly near.
bool has_near_in_order(const Points& points, std::size_t i, float reach_m, int count) {
  constexpr std::size_t looked_at = 8;
  const std::size_t end = std::min(points.size(), i + looked_at + 1);
  int found = 0;
  for (std::size_t j = i - std::min(i, looked_at); j < end; ++j) {
    const Eigen::Vector3f d = points[j] - points[i];
    found += d.x() * d.x() + d.y() * d.y() + d.z() * d.z() < reach_m * reach_m;
  }
  return found >= count;
}

/// Dust and stray returns stand alone: a point stays when three others of its sweep lie within 8 % of its range, or
/// 0.25 m (dynamic radius outlier removal: Charron, Phillips, Waslander, CRV 2018). Seen from the sweep's origin.
Points without_strays(const Points& points) {
  constexpr int companions = 3;
  constexpr float least_reach_m = 0.25F, reach_share = 0.08F;
  std::optional<KdTree> tree;
  Points kept;
  kept.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float reach_m = std::max(least_reach_m, reach_share * points[i].norm());
    bool stays = has_near_in_order(points, i, reach_m, companions + 1);
    if (!stays) {
      if (!tree) tree.emplace(points);
      stays = tree->has_within(points[i], reach_m, companions + 1);
    }
    if (stays) kept.push_back(points[i]);
  }
  return kept;
}

/// Removes what the other sweeps of the keyframe see through; there are no normals yet. A point that only one sweep hit
/// stays, because the others may be where they could not hit it; the submap checks again with the sweeps of
/// neighbouring keyframes (free_space).
Points without_transients(Points points, const std::vector<PreparedCloud::View>& views) {
  std::erase_if(points, [&](const Eigen::Vector3f& p) {
    int through = 0, hits = 0;
    for (const auto& view : views) {
      const Sight sight = view.image.look(p - view.origin, view_reach_m);
      through += sight == Sight::through;
      hits += sight == Sight::hit;
    }
    return is_transient(hits, through, 0);
  });
  return points;
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
