#include "server/verification/prepared_cloud.hpp"

#include <algorithm>

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

/// Dust and stray returns stand alone: a point stays when three others of its sweep lie within 8 % of its range, or
/// 0.25 m (dynamic radius outlier removal: Charron, Phillips, Waslander, CRV 2018). Seen from the sweep's origin.
Points without_strays(const Points& points) {
  constexpr std::size_t companions = 3;
  constexpr float least_reach_m = 0.25F, reach_share = 0.08F;
  const KdTree tree(points);
  Points kept;
  kept.reserve(points.size());
  for (const auto& p : points) {
    const float reach_m = std::max(least_reach_m, reach_share * p.norm());
    if (tree.has_within(p, reach_m, companions + 1)) kept.push_back(p);  // itself among them
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

/// Remembers which cubes were seen: open addressing over 64-bit keys.
class SeenCubes {
 public:
  explicit SeenCubes(std::size_t expected) {
    std::size_t size = 64;
    while (size < 2 * expected) size *= 2;
    slots_.assign(size, none);
  }
  bool first(std::uint64_t key) {
    if (2 * ++used_ > slots_.size()) grow();
    std::size_t at = mixed(key) & (slots_.size() - 1);
    while (slots_[at] != none && slots_[at] != key) at = (at + 1) & (slots_.size() - 1);
    const bool fresh = slots_[at] == none;
    slots_[at] = key;
    used_ -= !fresh;
    return fresh;
  }

 private:
  static constexpr std::uint64_t none = ~std::uint64_t{0};
  static std::size_t mixed(std::uint64_t key) { return (key * 0x9E3779B97F4A7C15U) >> 20; }
  void grow() {
    std::vector<std::uint64_t> old(2 * slots_.size(), none);
    old.swap(slots_);
    for (const std::uint64_t key : old) {
      if (key == none) continue;
      std::size_t at = mixed(key) & (slots_.size() - 1);
      while (slots_[at] != none) at = (at + 1) & (slots_.size() - 1);
      slots_[at] = key;
    }
  }
  std::vector<std::uint64_t> slots_;
  std::size_t used_ = 0;
};

/// The key of the cube of a point that lies within 16 km of the origin.
std::uint64_t cube(const Eigen::Vector3f& p, float leaf_m) {
  constexpr int half = 1 << 20;
  const Eigen::Vector3i c = (p / leaf_m).array().floor().cast<int>() + half;
  return std::uint64_t{static_cast<std::uint32_t>(c.x())} << 42 |
         std::uint64_t{static_cast<std::uint32_t>(c.y())} << 21 | static_cast<std::uint32_t>(c.z());
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

SurfelCloud sphere(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& centre, double radius_m, float leaf_m) {
  constexpr double sight_m = 12;  // clouds from farther out add little to the sphere but noise
  SurfelCloud out;
  SeenCubes seen(4096);
  const auto r2 = static_cast<float>(radius_m * radius_m);
  // The nearest clouds first: where several see a cube, the best view of it stays.
  std::vector<std::pair<double, const PlacedCloud*>> near;
  for (const PlacedCloud& c : clouds)
    if (const double d = (c.T_local_sensor.translation() - centre).norm(); d < radius_m + sight_m)
      near.emplace_back(d, &c);
  std::stable_sort(near.begin(), near.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
  for (const auto& [distance, c] : near) {
    // Relative to the centre: float keeps its precision however far a session has come.
    const Eigen::Matrix3f R = c->T_local_sensor.linear().cast<float>();
    const Eigen::Vector3f t = (c->T_local_sensor.translation() - centre).cast<float>(), origin = centre.cast<float>();
    for (std::size_t i = 0; i < c->cloud->points.size(); ++i) {
      const Eigen::Vector3f p = R * c->cloud->points[i] + t;
      if (p.squaredNorm() > r2 || !seen.first(cube(p, leaf_m))) continue;
      out.points.push_back(p + origin);
      out.normals.push_back(R * c->cloud->normals[i]);
    }
  }
  return out;
}

}  // namespace headframe
