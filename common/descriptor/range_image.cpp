#include "common/descriptor/range_image.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace headframe {
namespace {

constexpr float shown_from_m = 0.5F, shown_to_m = 60.0F, middle_m = 5.0F, log_spread = 1.5F;

/// Fills holes of at most `longest` along a line of n pixels that are `stride` apart; round: the line is cyclic.
void bridge(float* line, std::size_t n, std::size_t stride, std::size_t longest, bool round) {
  std::vector<std::size_t> seen;
  seen.reserve(n + 1);
  for (std::size_t i = 0; i < n; ++i)
    if (line[i * stride] > 0) seen.push_back(i);
  if (n < 2 || seen.size() < 2) return;
  if (round) seen.push_back(seen.front() + n);
  for (std::size_t k = 0; k + 1 < seen.size(); ++k) {
    const std::size_t gap = seen[k + 1] - seen[k] - 1;
    if (gap == 0 || gap > longest) continue;
    const float from = std::log(line[seen[k] * stride]), to = std::log(line[seen[k + 1] % n * stride]);
    for (std::size_t i = 1; i <= gap; ++i) {
      const float share = static_cast<float>(i) / static_cast<float>(gap + 1);
      line[(seen[k] + i) % n * stride] = std::exp(from + share * (to - from));
    }
  }
}

}  // namespace

RangeImage range_image(const Points& points_level, const RangeImageSpec& spec) {
  RangeImage image{spec, std::vector<float>(spec.rows * spec.columns, 0)};
  std::vector<float> count(image.range_m.size(), 0);
  constexpr double deg = std::numbers::pi / 180;
  const auto top = static_cast<float>(spec.top_deg * deg);
  const float rows_per_rad = static_cast<float>(spec.rows) / (top - static_cast<float>(spec.bottom_deg * deg));
  for (const auto& p : points_level) {
    const float r = p.norm();
    if (!(r > 0)) continue;
    const float row = (top - std::asin(std::clamp(p.z() / r, -1.0F, 1.0F))) * rows_per_rad;
    if (!(row >= 0 && row < static_cast<float>(spec.rows))) continue;
    const float turn = std::atan2(p.y(), p.x()) / (2 * std::numbers::pi_v<float>);
    const auto column = static_cast<std::size_t>((turn < 0 ? turn + 1 : turn) * static_cast<float>(spec.columns));
    const std::size_t pixel = static_cast<std::size_t>(row) * spec.columns + column % spec.columns;
    image.range_m[pixel] += std::log(r);
    count[pixel] += 1;
  }
  for (std::size_t i = 0; i < count.size(); ++i)
    if (count[i] > 0) image.range_m[i] = std::exp(image.range_m[i] / count[i]);
  return image;
}

void fill_small_holes(RangeImage& image, std::size_t rows, std::size_t columns) {
  const auto& spec = image.spec;
  for (std::size_t c = 0; c < spec.columns; ++c) bridge(&image.at(0, c), spec.rows, spec.columns, rows, false);
  for (std::size_t r = 0; r < spec.rows; ++r) bridge(&image.at(r, 0), spec.columns, 1, columns, true);
}

std::vector<float> log_range_and_mask(const RangeImage& image) {
  const std::size_t n = image.range_m.size();
  std::vector<float> planes(2 * n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    if (!(image.range_m[i] > 0)) continue;
    planes[i] = std::log(std::clamp(image.range_m[i], shown_from_m, shown_to_m) / middle_m) / log_spread;
    planes[n + i] = 1;
  }
  return planes;
}

double seen_share(const RangeImage& image) {
  const auto seen = std::count_if(image.range_m.begin(), image.range_m.end(), [](float r) { return r > 0; });
  return image.range_m.empty() ? 0 : static_cast<double>(seen) / static_cast<double>(image.range_m.size());
}

}  // namespace headframe
