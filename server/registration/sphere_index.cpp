#include "server/registration/sphere_index.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace headframe {
namespace {

constexpr float cell_m = 16;
constexpr float largest_chunk_m = 0.5F * ChunkedCloud::chunk_m * 1.7320508F;  // radius of the ball around a cube
constexpr std::size_t prefetched = 3;                                         // chunks ahead
constexpr float farthest_m = 1e6F;

Eigen::Vector3i cell_of(const Eigen::Vector3f& p, float size_m) { return (p / size_m).array().floor().cast<int>(); }

std::uint64_t key_of(const Eigen::Vector3i& cell) {
  const auto part = [](int v) { return (static_cast<std::uint64_t>(v) + (1U << 20U)) & 0x1FFFFFU; };
  return part(cell.x()) | part(cell.y()) << 21U | part(cell.z()) << 42U;
}

Chunk ball_around(const Points& points, std::size_t begin, std::size_t end) {
  Eigen::Vector3f low = points[begin], high = low;
  for (std::size_t i = begin; i < end; ++i) {
    low = low.cwiseMin(points[i]);
    high = high.cwiseMax(points[i]);
  }
  Chunk chunk{(low + high) / 2, 0, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end)};
  float squared = 0;
  for (std::size_t i = begin; i < end; ++i) squared = std::max(squared, (points[i] - chunk.centre).squaredNorm());
  chunk.radius_m = std::sqrt(squared);
  return chunk;
}

}  // namespace

ChunkedCloud cut_into_chunks(const Points& points, const Points& normals) {
  struct Entry {
    std::uint64_t key;
    std::uint32_t index;
  };
  std::vector<Entry> entries;
  entries.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i)
    if (points[i].allFinite() && points[i].cwiseAbs().maxCoeff() < farthest_m)
      entries.push_back({key_of(cell_of(points[i], ChunkedCloud::chunk_m)), i});
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return a.key < b.key || (a.key == b.key && a.index < b.index); });
  ChunkedCloud out;
  out.points.reserve(entries.size());
  if (!normals.empty()) out.normals.reserve(entries.size());
  for (const Entry& e : entries) {
    out.points.push_back(points[e.index]);
    if (!normals.empty()) out.normals.push_back(normals[e.index]);
  }
  for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
    while (end < entries.size() && entries[end].key == entries[begin].key) ++end;
    out.chunks.push_back(ball_around(out.points, begin, end));
  }
  return out;
}

void SphereIndex::add(const Pose& T_local_cloud, std::shared_ptr<const ChunkedCloud> cloud) {
  const auto id = static_cast<std::uint32_t>(clouds_.size());
  const Placed placed{T_local_cloud.linear().cast<float>(), T_local_cloud.translation().cast<float>(),
                      std::move(cloud)};
  for (const Chunk& chunk : placed.cloud->chunks) {
    const Eigen::Vector3f centre = placed.R * chunk.centre + placed.t;
    if (!(centre.cwiseAbs().maxCoeff() < farthest_m)) continue;
    cells_[key_of(cell_of(centre, cell_m))].push_back({id, chunk.begin, chunk.end, centre, chunk.radius_m});
  }
  clouds_.push_back(placed);
}

/// Chunks that may have points in the sphere, by cloud and place in it.
std::vector<SphereIndex::Reference> SphereIndex::near(const Eigen::Vector3f& centre, float radius_m) const {
  std::vector<Reference> out;
  const auto visit = [&](const std::vector<Reference>& cell) {
    for (const Reference& r : cell)
      if ((r.centre - centre).norm() < radius_m + r.radius_m) out.push_back(r);
  };
  const float reach_m = radius_m + largest_chunk_m;
  const double edge_cells = std::ceil(2.0 * reach_m / cell_m) + 1;
  if (edge_cells * edge_cells * edge_cells >= static_cast<double>(cells_.size())) {
    for (const auto& [key, cell] : cells_) visit(cell);
  } else {
    const Eigen::Vector3f reach = Eigen::Vector3f::Constant(reach_m);
    const Eigen::Vector3i low = cell_of(centre - reach, cell_m), high = cell_of(centre + reach, cell_m);
    for (int z = low.z(); z <= high.z(); ++z)
      for (int y = low.y(); y <= high.y(); ++y)
        for (int x = low.x(); x <= high.x(); ++x)
          if (const auto cell = cells_.find(key_of({x, y, z})); cell != cells_.end()) visit(cell->second);
  }
  std::sort(out.begin(), out.end(), [](const Reference& a, const Reference& b) {
    return a.cloud < b.cloud || (a.cloud == b.cloud && a.begin < b.begin);
  });
  return out;
}

/// A sphere's points are rarely in a cache: asked for early, they come while others are worked on.
void SphereIndex::prefetch(const Reference& r) const {
  const Eigen::Vector3f* points = clouds_[r.cloud].cloud->points.data();
  for (std::uint32_t i = r.begin; i < r.end; i += 64 / sizeof(Eigen::Vector3f)) __builtin_prefetch(points + i);
}

SphereIndex::Sample SphereIndex::sphere(const Eigen::Vector3d& centre_local, double radius_m) const {
  Sample out;
  if (!(centre_local.cwiseAbs().maxCoeff() < static_cast<double>(farthest_m)) || !(radius_m > 0)) return out;
  const Eigen::Vector3f centre = centre_local.cast<float>();
  const auto radius = static_cast<float>(radius_m);
  const std::vector<Reference> references = near(centre, radius);
  std::size_t most = 0;
  bool with_normals = true;
  for (const Reference& r : references) {
    most += r.end - r.begin;
    with_normals = with_normals && !clouds_[r.cloud].cloud->normals.empty();
  }
  out.points.reserve(most);
  if (with_normals) out.normals.reserve(most);
  for (std::size_t n = 0; n < references.size(); ++n) {
    const Reference& r = references[n];
    if (n + prefetched < references.size()) prefetch(references[n + prefetched]);
    const Placed& placed = clouds_[r.cloud];
    const std::size_t before = out.points.size();
    for (std::uint32_t i = r.begin; i < r.end; ++i) {
      const Eigen::Vector3f p = placed.R * placed.cloud->points[i] + placed.t;
      if (!((p - centre).squaredNorm() < radius * radius)) continue;
      out.points.push_back(p);
      if (with_normals) out.normals.emplace_back(placed.R * placed.cloud->normals[i]);
    }
    if (out.points.size() > before && (out.clouds.empty() || out.clouds.back() != r.cloud))
      out.clouds.push_back(r.cloud);
  }
  return out;
}

}  // namespace headframe
