#pragma once
// Triangles: of the rock, and of what stands in the mine.

#include <array>
#include <cstdint>
#include <vector>

#include "tests/mine/plan.hpp"

namespace headframe::mine {

struct Mesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

void append(Mesh& mesh, const Mesh& other);
void add_box(Mesh& mesh, const Box& box);
/// An open-ended tube of `sides` flat sides; its corners lie on the circle of the radius.
void add_tube(Mesh& mesh, const std::vector<Eigen::Vector3d>& line, double radius_m, int sides);

/// The surface of the plan's rock by surface nets on cells of cell_m, with what stands in it. Deterministic.
Mesh mesh_of(const Plan& plan, double cell_m = 0.25);

}  // namespace headframe::mine
