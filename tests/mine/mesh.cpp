#include "tests/mine/mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace headframe::mine {

void append(Mesh& mesh, const Mesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({a + first, b + first, c + first});
}

void add_box(Mesh& mesh, const Box& box) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  const double c = std::cos(box.yaw_rad), s = std::sin(box.yaw_rad);
  for (unsigned k = 0; k < 8; ++k) {  // bit 0: x, bit 1: y, bit 2: z
    const Eigen::Vector3d d =
        box.half_size.cwiseProduct(Eigen::Vector3d((k & 1) ? 1 : -1, (k & 2) ? 1 : -1, (k & 4) ? 1 : -1));
    mesh.vertices.emplace_back(
        (box.centre + Eigen::Vector3d(c * d.x() - s * d.y(), s * d.x() + c * d.y(), d.z())).cast<float>());
  }
  for (unsigned axis = 0; axis < 3; ++axis) {
    const std::uint32_t u = 1U << axis, v = 1U << ((axis + 1) % 3), w = 1U << ((axis + 2) % 3);
    for (const std::uint32_t side : {0U, w}) {
      const std::uint32_t k = first + side;
      mesh.triangles.push_back({k, k + u, k + u + v});
      mesh.triangles.push_back({k, k + u + v, k + v});
    }
  }
}

void add_tube(Mesh& mesh, const std::vector<Eigen::Vector3d>& line, double radius_m, int sides) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto n = static_cast<std::uint32_t>(sides);
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Eigen::Vector3d along = (line[std::min(i + 1, line.size() - 1)] - line[i > 0 ? i - 1 : 0]).normalized();
    const Eigen::Vector3d u =
        along.cross(std::abs(along.z()) < 0.9 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX()).normalized();
    const Eigen::Vector3d v = along.cross(u);
    for (std::uint32_t k = 0; k < n; ++k) {
      const double angle = 2 * std::numbers::pi * k / n;
      mesh.vertices.emplace_back((line[i] + radius_m * (std::cos(angle) * u + std::sin(angle) * v)).cast<float>());
    }
  }
  for (std::uint32_t i = 0; i + 1 < line.size(); ++i) {
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t a = first + i * n + k, b = first + i * n + (k + 1) % n;
      mesh.triangles.push_back({a, b, b + n});
      mesh.triangles.push_back({a, b + n, a + n});
    }
  }
}

}  // namespace headframe::mine
