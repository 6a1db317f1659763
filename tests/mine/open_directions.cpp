#include "tests/mine/open_directions.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace headframe::mine {

int open_directions(const RayCaster& caster, const Pose& T_world_sensor) {
  constexpr std::size_t rays = 180;
  constexpr float reach_m = 60;
  const Eigen::Vector3f eye = T_world_sensor.translation().cast<float>();
  std::vector<double> range_m(rays);
  for (std::size_t i = 0; i < rays; ++i) {
    const double azimuth = 2 * std::numbers::pi * static_cast<double>(i) / rays;
    const auto hit = caster.cast(eye, Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0).cast<float>(), reach_m);
    range_m[i] = hit ? hit->range_m : reach_m;
  }
  return open_directions(range_m);
}

int open_directions(const std::vector<double>& range_m) {
  const std::size_t n = range_m.size();
  auto sorted = range_m;
  const auto sixth = sorted.begin() + static_cast<std::ptrdiff_t>(n / 6);
  std::nth_element(sorted.begin(), sixth, sorted.end());
  const double far_m = std::max(6.0, 4 * *sixth);
  const auto wide = static_cast<std::size_t>(std::ceil(6.0 / 360 * static_cast<double>(n)));
  const auto apart = static_cast<std::size_t>(std::ceil(4.0 / 360 * static_cast<double>(n)));
  std::vector<bool> open(n);
  for (std::size_t i = 0; i < n; ++i) open[i] = range_m[i] > far_m;
  // Two runs of open sectors that lie less than `apart` from each other are one.
  const auto closed_for = [&](std::size_t i) {
    for (std::size_t k = 0; k < apart; ++k)
      if (open[(i + k) % n]) return false;
    return true;
  };
  std::size_t start = 0;
  while (start < n && !closed_for(start)) ++start;
  if (start == n) return 1;  // open all round
  int ways = 0;
  std::size_t width = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = (start + k) % n;
    if (open[i]) {
      ++width;
    } else if (width > 0 && closed_for(i)) {
      ways += width >= wide ? 1 : 0;
      width = 0;
    }
  }
  return ways + (width >= wide ? 1 : 0);
}

}  // namespace headframe::mine
