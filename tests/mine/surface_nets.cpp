// The rock's surface: a vertex in each cell that the surface crosses, a quad around each grid edge that crosses it.
// Blocks are meshed one by one; their common vertices come out equal, so no seam shows.

#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "tests/mine/mesh.hpp"
#include "tests/mine/parallel.hpp"
#include "tests/mine/rock.hpp"

namespace headframe::mine {
namespace {

constexpr int block_cells = 16;
constexpr int samples = block_cells + 2;  // from -1 to block_cells
constexpr std::uint32_t no_vertex = 0xffffffffU;

using BlockIndex = std::tuple<int, int, int>;

struct Block {
  Eigen::Vector3d corner;
  double cell_m;
  std::vector<float> depth = std::vector<float>(samples * samples * samples);
  std::vector<std::uint32_t> vertex = std::vector<std::uint32_t>(samples * samples * samples, no_vertex);
  Mesh mesh = {};

  static std::size_t index(const Eigen::Vector3i& c) {
    const Eigen::Matrix<std::size_t, 3, 1> k = (c.array() + 1).matrix().cast<std::size_t>();
    return (k.z() * samples + k.y()) * samples + k.x();
  }
  Eigen::Vector3d place(const Eigen::Vector3i& c) const { return corner + cell_m * c.cast<double>(); }
};

/// All blocks that a drift or a niche may touch.
std::set<BlockIndex> blocks_of(const Plan& plan, double block_m) {
  std::set<BlockIndex> blocks;
  const auto touch = [&](const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    const Eigen::Vector3i a = (low / block_m).array().floor().cast<int>(),
                          b = (high / block_m).array().floor().cast<int>();
    for (int x = a.x(); x <= b.x(); ++x)
      for (int y = a.y(); y <= b.y(); ++y)
        for (int z = a.z(); z <= b.z(); ++z) blocks.emplace(x, y, z);
  };
  for (const Drift& drift : plan.drifts) {
    const double side = 0.5 * drift.width_m + 1.5;
    for (std::size_t i = 0; i + 1 < drift.line.size(); ++i) {
      const Eigen::Vector3d along = drift.line[i + 1] - drift.line[i];
      const int steps = std::max(1, static_cast<int>(std::ceil(along.norm() / 2.0)));
      for (int k = 0; k <= steps; ++k) {
        const Eigen::Vector3d p = drift.line[i] + along * k / steps;
        touch(p - Eigen::Vector3d(side, side, 1.0), p + Eigen::Vector3d(side, side, drift.height_m + 1.0));
      }
    }
  }
  for (const Box& niche : plan.niches) {
    const double reach = niche.half_size.norm() + 0.8;
    touch(niche.centre - Eigen::Vector3d::Constant(reach), niche.centre + Eigen::Vector3d::Constant(reach));
  }
  return blocks;
}

void sample(Block& block, const Rock& rock) {
  const double size_m = block_cells * block.cell_m;
  const Eigen::Vector3d middle = block.corner + Eigen::Vector3d::Constant(0.5 * size_m);
  const auto near = rock.nearby(middle, 0.87 * size_m + 2 * block.cell_m);
  for (int z = -1; z <= block_cells; ++z)
    for (int y = -1; y <= block_cells; ++y)
      for (int x = -1; x <= block_cells; ++x)
        block.depth[Block::index({x, y, z})] = static_cast<float>(rock.depth_m(block.place({x, y, z}), near));
}

bool crossed(const Block& block, const Eigen::Vector3i& cell) {
  constexpr std::size_t dy = samples, dz = samples * samples;
  const float* d = block.depth.data() + Block::index(cell);
  const int open = (d[0] < 0) + (d[1] < 0) + (d[dy] < 0) + (d[dy + 1] < 0) + (d[dz] < 0) + (d[dz + 1] < 0) +
                   (d[dz + dy] < 0) + (d[dz + dy + 1] < 0);
  return open != 0 && open != 8;
}

/// The mean of the crossings of a cell's twelve edges.
void place_vertex(Block& block, const Eigen::Vector3i& cell) {
  if (!crossed(block, cell)) return;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int crossings = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < 4; ++k) {
      Eigen::Vector3i a = cell;
      a[(axis + 1) % 3] += k & 1;
      a[(axis + 2) % 3] += k >> 1;
      Eigen::Vector3i b = a;
      ++b[axis];
      const double da = block.depth[Block::index(a)], db = block.depth[Block::index(b)];
      if ((da < 0) == (db < 0)) continue;
      sum += block.place(a) + (da / (da - db)) * (block.place(b) - block.place(a));
      ++crossings;
    }
  }
  block.vertex[Block::index(cell)] = static_cast<std::uint32_t>(block.mesh.vertices.size());
  block.mesh.vertices.emplace_back((sum / crossings).cast<float>());
}

void add_quads(Block& block, const Eigen::Vector3i& a) {
  if (block.vertex[Block::index(a)] == no_vertex) return;  // the cell of `a` has all three edges as its own
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3i b = a;
    ++b[axis];
    if ((block.depth[Block::index(a)] < 0) == (block.depth[Block::index(b)] < 0)) continue;
    Eigen::Vector3i u = Eigen::Vector3i::Zero(), v = Eigen::Vector3i::Zero();
    u[(axis + 1) % 3] = 1;
    v[(axis + 2) % 3] = 1;
    const auto corner = [&](const Eigen::Vector3i& cell) { return block.vertex[Block::index(cell)]; };
    const std::uint32_t p = corner(a), q = corner(a - u), r = corner(a - u - v), s = corner(a - v);
    block.mesh.triangles.push_back({p, q, r});
    block.mesh.triangles.push_back({p, r, s});
  }
}

Mesh mesh_block(const Rock& rock, const BlockIndex& index, double cell_m) {
  const auto [bx, by, bz] = index;
  Block block{.corner = block_cells * cell_m * Eigen::Vector3d(bx, by, bz), .cell_m = cell_m};
  sample(block, rock);
  for (int z = -1; z < block_cells; ++z)
    for (int y = -1; y < block_cells; ++y)
      for (int x = -1; x < block_cells; ++x) place_vertex(block, {x, y, z});
  if (block.mesh.vertices.empty()) return {};
  for (int z = 0; z < block_cells; ++z)
    for (int y = 0; y < block_cells; ++y)
      for (int x = 0; x < block_cells; ++x) add_quads(block, {x, y, z});
  return std::move(block.mesh);
}

}  // namespace

Mesh mesh_of(const Plan& plan, double cell_m) {
  const Rock rock(plan);
  const auto touched = blocks_of(plan, block_cells * cell_m);
  const std::vector<BlockIndex> blocks(touched.begin(), touched.end());
  std::vector<Mesh> parts(blocks.size());
  for_each_index(blocks.size(), [&](std::size_t i) { parts[i] = mesh_block(rock, blocks[i], cell_m); });
  Mesh mesh = {};
  for (const Mesh& part : parts) append(mesh, part);
  for (const Box& box : plan.vehicles) add_box(mesh, box);
  for (const Pipe& pipe : plan.pipes) add_tube(mesh, pipe.line, pipe.radius_m, 8);
  return mesh;
}

}  // namespace headframe::mine
