#include "common/descriptor/wall_profile.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace headframe {
namespace {

constexpr float nearest_m = 0.3F;
constexpr float farthest_m = 120.0F;
constexpr float steps = 253.0F;        // codes 1 to 254
constexpr float band_slope = 0.0787F;  // tan 4.5 deg

}  // namespace

std::uint8_t encode_wall_range(float range_m) {
  if (!(range_m >= nearest_m)) return 0;
  const float u = std::log(std::min(range_m, farthest_m) / nearest_m) / std::log(farthest_m / nearest_m);
  return static_cast<std::uint8_t>(1 + std::lround(u * steps));
}

float decode_wall_range_m(std::uint8_t code) {
  static const std::array<float, 256> ranges_m = [] {
    std::array<float, 256> out{};  // code 0: no return
    for (std::size_t i = 1; i < out.size(); ++i)
      out[i] = nearest_m * std::pow(farthest_m / nearest_m, static_cast<float>(i - 1) / steps);
    return out;
  }();
  return ranges_m[code];
}

WallProfile wall_profile(const Points& points_level) {
  // The median of a sector's ranges, so that a pipe in front of the wall or one return from dust does not change it.
  std::array<std::vector<float>, WallProfile::sectors> ranges;
  for (const auto& p : points_level) {
    const float r = std::hypot(p.x(), p.y());
    if (r < nearest_m || std::abs(p.z()) > band_slope * r) continue;
    const float turn = std::atan2(p.y(), p.x()) / (2 * std::numbers::pi_v<float>);
    const auto sector = static_cast<std::size_t>((turn < 0 ? turn + 1 : turn) * WallProfile::sectors);
    ranges[std::min(sector, WallProfile::sectors - 1)].push_back(r);
  }
  WallProfile profile;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    auto& r = ranges[i];
    if (r.empty()) continue;
    const auto middle = r.begin() + static_cast<std::ptrdiff_t>(r.size() / 2);
    std::nth_element(r.begin(), middle, r.end());
    profile.code[i] = encode_wall_range(*middle);
  }
  return profile;
}

}  // namespace headframe
