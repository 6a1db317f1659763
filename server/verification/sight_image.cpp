#include "server/verification/sight_image.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "server/support/wide.hpp"

namespace headframe {
namespace {

constexpr float radians_per_bin = std::numbers::pi_v<float> / 90;

// Without branches and calls, so that loops over many points are vectorised.

/// To 1.4e-4 rad: a fit of atan(t) / t for |t| <= 1 by a cubic in t^2.
[[gnu::always_inline]] inline float quick_atan2(float y, float x) {
  const float high = std::max(std::abs(x), std::abs(y)), low = std::min(std::abs(x), std::abs(y));
  const float quotient = low / high, t = high > 0 ? quotient : 0, s = t * t;
  const float flat = t * (0.9997528F + s * (-0.3252305F + s * (0.1540952F + s * -0.04335934F)));
  const float complement = std::numbers::pi_v<float> / 2 - flat;
  const float ahead = std::abs(y) > std::abs(x) ? complement : flat;
  const float supplement = std::numbers::pi_v<float> - ahead;
  const float angle = x < 0 ? supplement : ahead;
  return y < 0 ? -angle : angle;
}

[[gnu::always_inline]] inline int floored(float v) {
  const int i = static_cast<int>(v);
  return i - static_cast<int>(v < static_cast<float>(i));
}

[[gnu::always_inline]] inline int column_of(float x, float y) {
  return floored(quick_atan2(y, x) / radians_per_bin) + SightImage::columns / 2;
}

[[gnu::always_inline]] inline int row_of(float across, float z) {
  return floored(quick_atan2(z, across) / radians_per_bin + SightImage::rows / 2.0F);
}

/// Of all points of a block.
struct Directions {
  std::array<float, SightBlock::most> range;
  std::array<int, SightBlock::most> column, row;
};

HEADFRAME_WIDE void find_directions(const SightBlock& points, Directions& out) {
  const float *x = points.x.data(), *y = points.y.data(), *z = points.z.data();
  std::array<float, SightBlock::most> across;
  for (std::size_t i = 0; i < points.count; ++i) {
    across[i] = std::sqrt(x[i] * x[i] + y[i] * y[i]);
    out.range[i] = std::sqrt(x[i] * x[i] + (y[i] * y[i] + z[i] * z[i]));
  }
  for (std::size_t i = 0; i < points.count; ++i) {
    out.column[i] = column_of(x[i], y[i]);
    out.row[i] = row_of(across[i], z[i]);
  }
}

std::size_t index_of(int row, int column) {
  constexpr int n = SightImage::columns;
  return static_cast<std::size_t>(row) * n + static_cast<std::size_t>((column + n) % n);
}

}  // namespace

SightImage::SightImage(const Points& points) {
  std::vector<Bin> all(static_cast<std::size_t>(columns) * rows);
  first_row_ = rows;
  for (const auto& p : points) {
    const float range = p.norm();
    if (!(range > 0.1F)) continue;
    const Direction d = direction(p.x(), p.y(), p.z());
    if (d.row < 0 || d.row >= rows) continue;
    Bin& bin = all[index_of(d.row, d.column)];
    const auto range_cm = static_cast<std::uint16_t>(std::min(range * 100, 65535.0F));
    bin.near_cm = bin.near_cm > 0 ? std::min(bin.near_cm, range_cm) : range_cm;
    bin.far_cm = std::max(bin.far_cm, range_cm);
    first_row_ = std::min(first_row_, d.row);
    end_row_ = std::max(end_row_, d.row + 1);
  }
  if (end_row_ == 0) return;
  bins_.assign(all.begin() + first_row_ * columns, all.begin() + end_row_ * columns);
  for (int row = first_row_; row < end_row_; ++row)
    for (int column = 0; column < columns; ++column) sum_up(row, column);
}

const SightImage::Bin& SightImage::bin(int row, int column) const { return bins_[index_of(row - first_row_, column)]; }

void SightImage::sum_up(int row, int column) {
  Bin& sum = bins_[index_of(row - first_row_, column)];
  sum.nearest_cm = std::numeric_limits<std::uint16_t>::max();
  for (int r = std::max(first_row_, row - 1); r <= std::min(end_row_ - 1, row + 1); ++r)
    for (int step = -1; step <= 1; ++step) {
      const Bin& other = bin(r, column + step);
      if (other.near_cm == 0) continue;
      sum.nearest_cm = std::min(sum.nearest_cm, other.near_cm);
      sum.farthest_cm = std::max(sum.farthest_cm, other.far_cm);
    }
}

SightImage::Direction SightImage::direction(float x, float y, float z) {
  return {column_of(x, y), row_of(std::sqrt(x * x + y * y), z)};
}

Sight SightImage::look(const Eigen::Vector3f& point, float reach_m) const {
  return look(direction(point.x(), point.y(), point.z()), point.norm(), reach_m);
}

void SightImage::look(const SightBlock& points, float reach_m, std::span<Sight, SightBlock::most> answers) const {
  Directions to;
  find_directions(points, to);
  for (std::size_t i = 0; i < points.count; ++i) answers[i] = look({to.column[i], to.row[i]}, to.range[i], reach_m);
}

Sight SightImage::look(Direction d, float range, float reach_m) const {
  if (range > reach_m || range < 0.5F) return Sight::unknown;
  if (d.row < first_row_ || d.row >= end_row_) return Sight::unknown;
  const Bin& ahead = bin(d.row, d.column);
  if (ahead.near_cm == 0) return Sight::unknown;
  const float tolerance = 0.35F + 0.03F * range;
  if (range < 0.01F * ahead.nearest_cm - tolerance) return Sight::through;
  if (range >= 0.01F * ahead.farthest_cm + tolerance) return Sight::unknown;
  // The ranges between the nearest and the farthest of a bin belong to a slanted wall, or to dust and the wall behind
  // it.
  const auto meets = [&](const Bin& b) {
    return b.near_cm > 0 &&
           (std::abs(range - 0.01F * b.near_cm) < tolerance || std::abs(range - 0.01F * b.far_cm) < tolerance);
  };
  if (meets(ahead)) return Sight::hit;
  // A surface seen at a flat angle has very different ranges in neighbouring bins, so these are checked too.
  for (int row = std::max(first_row_, d.row - 1); row <= std::min(end_row_ - 1, d.row + 1); ++row)
    for (int step = -1; step <= 1; ++step)
      if (meets(bin(row, d.column + step))) return Sight::hit;
  return Sight::unknown;
}

}  // namespace headframe
