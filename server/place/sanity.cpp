#include "server/place/sanity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/descriptor/wall_profile.hpp"

namespace headframe {
namespace {

constexpr double reach_m = 20, farthest_neighbour_m = 25;
constexpr double slack_m = 0.8, slack_share = 0.1;  // a profile's sector is 2 deg wide, and walls are rough
constexpr int least_asked = 15;
// Limits for the agreement with neighbours, relative to that of the neighbours with each other; set on simulated mines
// and recordings. Underground, where neighbours agree well, a sound keyframe has 0.72 or more, and a scan from
// elsewhere mostly less than 0.65. In the open one in ten sound keyframes has less than 0.65, and one in forty less
// than 0.35. Noise is always found underground, and in the open three times in four.
constexpr double agree_well = 0.7, least_share_underground = 0.65, least_share_open = 0.35;

/// Directions of the middles of the sectors.
const std::array<Eigen::Vector2d, WallProfile::sectors>& sector_directions() {
  static const auto directions = [] {
    std::array<Eigen::Vector2d, WallProfile::sectors> out;
    for (std::size_t i = 0; i < out.size(); ++i) {
      const double azimuth_rad = (static_cast<double>(i) + 0.5) * 2 * std::numbers::pi / WallProfile::sectors;
      out[i] = {std::cos(azimuth_rad), std::sin(azimuth_rad)};
    }
    return out;
  }();
  return directions;
}

double range_towards(const Keyframe& k, double azimuth_rad) {
  const double turn = azimuth_rad / (2 * std::numbers::pi);
  const auto i = static_cast<std::size_t>((turn - std::floor(turn)) * WallProfile::sectors);
  return static_cast<double>(decode_wall_range_m(k.walls.code[i % WallProfile::sectors]));
}

}  // namespace

std::optional<double> agreement(const Keyframe& a, const Keyframe& b) {
  const Pose T_a_b = levelled(a.T_local_sensor).inverse() * levelled(b.T_local_sensor);
  int met = 0, asked = 0;
  for (std::size_t i = 0; i < WallProfile::sectors; ++i) {
    const double r = static_cast<double>(decode_wall_range_m(b.walls.code[i]));
    if (r == 0 || r > reach_m) continue;
    const Eigen::Vector2d direction = sector_directions()[i];
    const Eigen::Vector3d p = T_a_b * Eigen::Vector3d(r * direction.x(), r * direction.y(), 0);
    const double wall_m = range_towards(a, std::atan2(p.y(), p.x())), here_m = p.head<2>().norm();
    const double slack = slack_m + slack_share * here_m;
    if (wall_m == 0 || here_m > wall_m + slack) continue;  // hidden
    ++asked;
    met += here_m > wall_m - slack;
  }
  if (asked < least_asked) return std::nullopt;
  return static_cast<double>(met) / asked;
}

namespace {

/// The lower value of both directions.
std::optional<double> mutual(const Keyframe& a, const Keyframe& b) {
  if ((a.T_local_sensor.translation() - b.T_local_sensor.translation()).norm() > farthest_neighbour_m)
    return std::nullopt;
  const auto there = agreement(a, b), back = agreement(b, a);
  if (!there || !back) return std::nullopt;
  return std::min(*there, *back);
}

/// A single outlier among the neighbours does not condemn a keyframe.
double second_best(std::vector<double> values) {
  std::sort(values.begin(), values.end(), std::greater<>());
  return values[std::min<std::size_t>(1, values.size() - 1)];
}

}  // namespace

bool fits_neighbours(std::span<const Keyframe> keyframes, std::size_t i) {
  const std::size_t first = i < 2 ? 0 : i - 2, last = std::min(keyframes.size(), i + 3);
  std::vector<double> with_it;
  for (std::size_t k = first; k < last; ++k)
    if (k != i)
      if (const auto said = mutual(keyframes[k], keyframes[i])) with_it.push_back(*said);
  if (with_it.size() < 2) return true;
  const double own = second_best(with_it);
  if (own >= least_share_underground) return true;  // however well the others agree with each other
  std::vector<double> without;
  for (std::size_t k = first; k < last; ++k)
    for (std::size_t l = k + 1; l < last; ++l)
      if (k != i && l != i)
        if (const auto said = mutual(keyframes[k], keyframes[l])) without.push_back(*said);
  if (without.empty()) return true;
  const double beside = second_best(without);
  return own >= beside * (beside >= agree_well ? least_share_underground : least_share_open);
}

}  // namespace headframe
