#include "server/registration/range_image.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace headframe {
namespace {

constexpr float radians_per_bin = std::numbers::pi_v<float> / 90;

struct Direction {
  int column, row;
};

Direction direction(const Eigen::Vector3f& p, float range) {
  const float azimuth = std::atan2(p.y(), p.x());
  const float elevation = std::asin(std::clamp(p.z() / range, -1.0F, 1.0F));
  return {static_cast<int>(std::floor(azimuth / radians_per_bin)) + RangeImage::columns / 2,
          static_cast<int>(std::floor(elevation / radians_per_bin + RangeImage::rows / 2.0F))};
}

std::size_t index_of(int row, int column) {
  constexpr int n = RangeImage::columns;
  return static_cast<std::size_t>(row) * n + static_cast<std::size_t>((column + n) % n);
}

}  // namespace

RangeImage::RangeImage(const Points& points) : bins_(static_cast<std::size_t>(columns) * rows) {
  for (const auto& p : points) {
    const float range = p.norm();
    if (!(range > 0.1F)) continue;
    const Direction d = direction(p, range);
    if (d.row < 0 || d.row >= rows) continue;
    Bin& bin = bins_[index_of(d.row, d.column)];
    const auto range_cm = static_cast<std::uint16_t>(std::min(range * 100, 65535.0F));
    bin.near_cm = bin.near_cm > 0 ? std::min(bin.near_cm, range_cm) : range_cm;
    bin.far_cm = std::max(bin.far_cm, range_cm);
  }
}

Sight RangeImage::look(const Eigen::Vector3f& point, float reach_m) const {
  const float range = point.norm();
  if (range > reach_m || range < 0.5F) return Sight::unknown;
  const Direction d = direction(point, range);
  const float tolerance = 0.35F + 0.03F * range;
  if (d.row < 0 || d.row >= rows || bins_[index_of(d.row, d.column)].near_cm == 0) return Sight::unknown;
  // A surface seen at a flat angle spans many ranges from one bin to the next: the neighbours speak too.
  float nearest = std::numeric_limits<float>::max();
  for (int row = std::max(0, d.row - 1); row <= std::min(rows - 1, d.row + 1); ++row)
    for (int step = -1; step <= 1; ++step) {
      const Bin& bin = bins_[index_of(row, d.column + step)];
      if (bin.near_cm == 0) continue;
      const float near_m = 0.01F * bin.near_cm, far_m = 0.01F * bin.far_cm;
      // Between the nearest and the farthest of a bin lies a slanted wall, or a dust return and the wall behind it.
      if (std::abs(range - near_m) < tolerance || std::abs(range - far_m) < tolerance) return Sight::hit;
      nearest = std::min(nearest, near_m);
    }
  return range < nearest - tolerance ? Sight::through : Sight::unknown;
}

}  // namespace headframe
