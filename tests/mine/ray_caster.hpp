#pragma once
// Rays against a mesh.

#include <memory>
#include <optional>

#include "tests/mine/mesh.hpp"

namespace headframe::mine {

struct Hit {
  float range_m = 0;
  float incidence = 1;  // |cosine| between the ray and the surface's normal
};

/// Immutable once built; cast() may be called from many threads at once. Movable.
class RayCaster {
 public:
  explicit RayCaster(const Mesh& mesh);
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  /// The first surface within max_range_m along a unit direction.
  std::optional<Hit> cast(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float max_range_m) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace headframe::mine
