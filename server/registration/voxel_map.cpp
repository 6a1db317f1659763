#include "server/registration/voxel_map.hpp"

#include "server/support/wide.hpp"

namespace headframe {
namespace {

constexpr float farthest_cell = 1e6F;
constexpr int widest = 500;        // cells from the first point
constexpr float far_away = 1e18F;  // its square still fits a float

int floored(float v) {
  const int i = static_cast<int>(v);
  return i - static_cast<int>(v < static_cast<float>(i));
}

/// Returns false if p is not finite or too far away.
bool cell_of(const Eigen::Vector3f& p, float per_m, Eigen::Vector3i& cell) {
  for (int a = 0; a < 3; ++a) {
    const float v = p[a] * per_m;
    if (!(v > -farthest_cell && v < farthest_cell)) return false;
    cell[a] = floored(v);
  }
  return true;
}

}  // namespace

VoxelMap::VoxelMap(const Points& points, const Points& normals, float leaf_m)
    : leaf_m_(leaf_m), voxels_(1), bricks_(1) {
  voxels_[0].mean.setConstant(far_away);
  std::vector<Eigen::Vector3i> cells;
  std::vector<std::size_t> taken;
  for (std::size_t i = 0; i < points.size(); ++i) {
    Eigen::Vector3i cell;
    if (!cell_of(points[i], 1 / leaf_m_, cell)) continue;
    if (!cells.empty() && (cell - cells.front()).cwiseAbs().maxCoeff() > widest) continue;
    cells.push_back(cell);
    taken.push_back(i);
  }
  lay_out(cells);
  for (std::size_t k = 0; k < cells.size(); ++k) {
    std::uint32_t id = voxel_at(cells[k]);
    if (id == 0) {
      id = static_cast<std::uint32_t>(voxels_.size());
      voxels_.emplace_back();
      share(cells[k], id);
    }
    Voxel& voxel = voxels_[id];
    voxel.mean += points[taken[k]];
    const Symmetric3f N = outer(normals[taken[k]]);
    for (std::size_t n = 0; n < N.size(); ++n) voxel.N[n] += N[n];
    voxel.count += 1;
  }
  for (Voxel& voxel : voxels_) {
    if (voxel.count == 0) continue;
    voxel.mean /= voxel.count;
    for (float& n : voxel.N) n /= voxel.count;
  }
  means_.reserve(voxels_.size());
  for (const Voxel& voxel : voxels_) means_.push_back(Float4{voxel.mean.x(), voxel.mean.y(), voxel.mean.z(), 0});
}

/// A grid of bricks that holds the cells and their neighbours.
void VoxelMap::lay_out(const std::vector<Eigen::Vector3i>& cells) {
  if (cells.empty()) return;
  Eigen::Vector3i low = cells.front(), high = low;
  for (const Eigen::Vector3i& cell : cells) {
    low = low.cwiseMin(cell);
    high = high.cwiseMax(cell);
  }
  low.array() -= 1;  // nearest() begins one cell before a voxel's own
  const Eigen::Vector3i bricks = (high - low) / own + Eigen::Vector3i::Ones(), end = low + own * bricks;
  bricks_x_ = bricks.x();
  bricks_y_ = bricks.y();
  brick_at_.resize(static_cast<std::size_t>(bricks.x()) * static_cast<std::size_t>(bricks.y()) *
                   static_cast<std::size_t>(bricks.z()));
  low_ = Mask4{low.x(), low.y(), low.z(), 0};
  low_cell_ = __builtin_convertvector(low_, Float4);
  end_ = __builtin_convertvector((Mask4{end.x(), end.y(), end.z(), 1}), Float4);
}

std::size_t VoxelMap::offset(int x, int y, int z) {
  const int at = (z * edge + y) * edge + x;
  return static_cast<std::size_t>(at);
}

std::size_t VoxelMap::index_of(int x, int y, int z) const {
  const int at = (z * bricks_y_ + y) * bricks_x_ + x;
  return static_cast<std::size_t>(at);
}

VoxelMap::Brick& VoxelMap::brick(const Eigen::Vector3i& at) {
  std::uint32_t& number = brick_at_[index_of(at.x(), at.y(), at.z())];
  if (number == 0) {
    number = static_cast<std::uint32_t>(bricks_.size());
    bricks_.emplace_back();
  }
  return bricks_[number];
}

/// The brick of a cell, and the cell's place within it.
std::pair<Eigen::Vector3i, Eigen::Vector3i> VoxelMap::place_of(const Eigen::Vector3i& cell) const {
  const Eigen::Vector3i in_grid = cell - Eigen::Vector3i(low_[0], low_[1], low_[2]), at = in_grid / own;
  return {at, in_grid - own * at};
}

std::uint32_t& VoxelMap::voxel_at(const Eigen::Vector3i& cell) {
  const auto [at, local] = place_of(cell);
  return brick(at).voxels[offset(local.x(), local.y(), local.z())];
}

/// Writes the voxel into its own brick and into the preceding ones that contain it as their next layer.
void VoxelMap::share(const Eigen::Vector3i& cell, std::uint32_t voxel) {
  const auto [at, local] = place_of(cell);
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3i back(corner & 1, corner >> 1 & 1, corner >> 2);
    if ((back.array() > 0 && local.array() > 0).any()) continue;
    const Eigen::Vector3i to = local + own * back;
    brick(at - back).voxels[offset(to.x(), to.y(), to.z())] = voxel;
  }
}

/// Squared distances of the means of four voxels from p.
[[gnu::always_inline]] inline Float4 VoxelMap::squared_m(const Mask4& voxels, const Eigen::Vector3f& p) const {
  const auto mean = [&](int lane) { return means_[static_cast<std::size_t>(voxels[lane])]; };
  const Float4 a = mean(0), b = mean(1), c = mean(2), d = mean(3);
  const Float4 ab = __builtin_shufflevector(a, b, 0, 4, 1, 5), cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
  const Float4 x = __builtin_shufflevector(ab, cd, 0, 1, 4, 5) - p.x();
  const Float4 y = __builtin_shufflevector(ab, cd, 2, 3, 6, 7) - p.y();
  const Float4 z = __builtin_shufflevector(__builtin_shufflevector(a, b, 2, 6, 2, 6),
                                           __builtin_shufflevector(c, d, 2, 6, 2, 6), 0, 1, 4, 5) -
                   p.z();
  return x * x + (y * y + z * z);
}

/// Almost without branches: which voxel is nearest cannot be predicted.
[[gnu::always_inline]] inline const Voxel* VoxelMap::look_up(const Eigen::Vector3f& p) const {
  const float per_m = 1 / leaf_m_;
  const Float4 v = Float4{p.x() * per_m, p.y() * per_m, p.z() * per_m, 0.5F} - 0.5F;
  if (any(~((v >= low_cell_) & (v < end_)))) return nullptr;  // also what is not a number
  Mask4 cell = __builtin_convertvector(v, Mask4);
  cell += v < __builtin_convertvector(cell, Float4);  // rounded down
  const Mask4 in_grid = cell - low_, at = in_grid >> 2, local = in_grid & 3;
  const Brick& brick = bricks_[brick_at_[index_of(at[0], at[1], at[2])]];
  const std::uint32_t* first = &brick.voxels[offset(local[0], local[1], local[2])];
  constexpr int row = edge, layer = edge * edge;
  const auto four = [](const std::uint32_t* of) {
    return Mask4{static_cast<int>(of[0]), static_cast<int>(of[1]), static_cast<int>(of[row]),
                 static_cast<int>(of[row + 1])};
  };
  // An empty cell is voxel 0, which is far away.
  const Mask4 low = four(first), high = four(first + layer);
  const Float4 squared_low = squared_m(low, p), squared_high = squared_m(high, p);
  const Mask4 is_high = squared_high < squared_low;
  Float4 squared = is_high ? squared_high : squared_low;
  Mask4 ids = is_high ? high : low;
  const auto keep_nearer = [&](const Float4& other, const Mask4& other_ids) {
    const Mask4 nearer = other < squared;
    squared = nearer ? other : squared;
    ids = nearer ? other_ids : ids;
  };
  keep_nearer(__builtin_shufflevector(squared, squared, 1, 0, 3, 2), __builtin_shufflevector(ids, ids, 1, 0, 3, 2));
  keep_nearer(__builtin_shufflevector(squared, squared, 2, 3, 0, 1), __builtin_shufflevector(ids, ids, 2, 3, 0, 1));
  return ids[0] == 0 ? nullptr : &voxels_[static_cast<std::size_t>(ids[0])];
}

const Voxel* VoxelMap::nearest(const Eigen::Vector3f& p) const { return look_up(p); }

HEADFRAME_WIDE void VoxelMap::nearest(std::span<const Eigen::Vector3f> points, std::span<const Voxel*> answers) const {
  for (std::size_t i = 0; i < points.size(); ++i) answers[i] = look_up(points[i]);
}

}  // namespace headframe
