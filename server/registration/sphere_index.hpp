#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"

namespace headframe {

/// Consecutive points of a cloud that lie in one cube, and a ball around them, in the cloud's frame.
struct Chunk {
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();
  float radius_m = 0;
  std::uint32_t begin = 0, end = 0;
};

/// A cloud whose points are sorted by cubes of chunk_m.
struct ChunkedCloud {
  static constexpr float chunk_m = 4;
  Points points;
  Points normals;  // one a point, or none at all
  std::vector<Chunk> chunks;
};

/// Sorts points (and normals, one a point or none) into chunks; within a chunk they keep their order. Points that are
/// not finite or lie over 1000 km from the origin are left out.
ChunkedCloud cut_into_chunks(const Points& points, const Points& normals = {});

/// Clouds of one session where it says they lie, found by place: a query costs by the sphere and what is in it, not by
/// the map. Clouds are shared, not copied. Queries are thread safe while nothing is added.
class SphereIndex {
 public:
  /// A cloud's number is how many were added before it. Chunks over 1000 km from the origin are never found.
  void add(const Pose& T_local_cloud, std::shared_ptr<const ChunkedCloud> cloud);
  std::size_t clouds() const { return clouds_.size(); }

  struct Sample {
    Points points, normals;             // in the local frame; no normals when a cloud has none
    std::vector<std::uint32_t> clouds;  // that have points in the sphere, ascending
  };

  /// All points nearer than radius_m, cloud by cloud in the order they were added.
  Sample sphere(const Eigen::Vector3d& centre_local, double radius_m) const;

 private:
  struct Placed {
    Eigen::Matrix3f R;
    Eigen::Vector3f t;
    std::shared_ptr<const ChunkedCloud> cloud;
  };
  struct Reference {
    std::uint32_t cloud, begin, end;  // points of the chunk
    Eigen::Vector3f centre;           // local frame
    float radius_m;
  };
  void prefetch(const Reference& r) const;
  std::vector<Reference> near(const Eigen::Vector3f& centre, float radius_m) const;

  std::vector<Placed> clouds_;
  std::unordered_map<std::uint64_t, std::vector<Reference>> cells_;  // chunks by the cell that their centre lies in
};

}  // namespace headframe
