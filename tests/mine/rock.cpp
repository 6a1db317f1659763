#include "tests/mine/rock.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "tests/mine/noise.hpp"

namespace headframe::mine {
namespace {

constexpr double reach_m = 3.0;          // beyond this a drift says nothing
constexpr double max_roughness_m = 0.8;  // no octave sum is larger

struct Profile {
  double wall_m;   // depth into the wall or the roof
  double floor_m;  // depth below the floor
};

/// The cross section at p: upright walls up to 60 % of the height, an elliptic roof above.
Profile profile(const Eigen::Vector3d& p, const Rock::Nearby::Segment& s) {
  const Eigen::Vector2d along = (s.b - s.a).head<2>();
  const double t = std::clamp((p - s.a).head<2>().dot(along) / std::max(along.squaredNorm(), 1e-9), 0.0, 1.0);
  const Eigen::Vector3d foot = s.a + t * (s.b - s.a);
  const double half_width_m = 0.5 * s.drift->width_m, spring_m = 0.6 * s.drift->height_m;
  const double height_m = p.z() - foot.z(), lateral_m2 = (p - foot).head<2>().squaredNorm();
  const double arch_m = std::max(0.0, height_m - spring_m) * half_width_m / (s.drift->height_m - spring_m);
  return {std::sqrt(lateral_m2 + arch_m * arch_m) - half_width_m, -height_m};
}

double smooth_min(double a, double b, double k) {
  const double h = std::max(0.0, k - std::abs(a - b)) / k;
  return std::min(a, b) - 0.25 * h * h * k;
}

double box_depth_m(const Eigen::Vector3d& p, const Box& box) {
  const double c = std::cos(box.yaw_rad), s = std::sin(box.yaw_rad);
  const Eigen::Vector3d d = p - box.centre;
  const Eigen::Vector3d q(c * d.x() + s * d.y(), -s * d.x() + c * d.y(), d.z());
  return (q.cwiseAbs() - box.half_size).maxCoeff();
}

double cone_depth_m(const Eigen::Vector3d& p, const Pile& pile) {  // positive inside the gravel
  const Eigen::Vector3d d = p - pile.foot;
  const double steep = pile.height_m / pile.radius_m;
  return (pile.height_m - d.z() - steep * d.head<2>().norm()) / std::hypot(1.0, steep);
}

/// A place in the tile's own axes: the tile turned so that its openings are in standard order.
struct TilePlace {
  Eigen::Vector3d p;
  std::uint64_t shape;
  double fade;  // 1 within the tile, 0 at its border, so that neighbours fit
};

/// By how many quarter turns a tile is turned, and what it is a copy of.
std::pair<unsigned, std::uint64_t> turned_shape(const Tiling& tiling, std::size_t tile) {
  if (!tiling.pieces.empty()) return {tiling.pieces[tile].quarter_turns, piece_seed + tiling.pieces[tile].number};
  const unsigned open = tiling.open[tile];
  unsigned best = open, turns = 0;
  for (unsigned k = 1; k < 4; ++k) {
    const unsigned turned = ((open >> k) | (open << (4 - k))) & 15U;
    if (turned < best) best = turned, turns = k;
  }
  return {turns, best};
}

TilePlace tile_place(const Tiling& tiling, const Eigen::Vector3d& p) {
  const Eigen::Vector3d q = (p - tiling.origin) / tiling.tile_m;
  const double i = std::round(q.x()), j = std::round(q.y());
  const std::size_t row_count = tiling.open.size() / tiling.columns;
  const auto rows = static_cast<double>(row_count);
  if (i < 0 || j < 0 || i >= static_cast<double>(tiling.columns) || j >= rows) return {p, 0, 0};
  const auto [turns, shape] =
      turned_shape(tiling, static_cast<std::size_t>(j) * tiling.columns + static_cast<std::size_t>(i));
  const double angle = -0.5 * std::numbers::pi * turns;
  const Eigen::Vector3d local = p - tiling.origin - tiling.tile_m * Eigen::Vector3d(i, j, 0);
  const Eigen::Vector3d own(std::cos(angle) * local.x() - std::sin(angle) * local.y(),
                            std::sin(angle) * local.x() + std::cos(angle) * local.y(), local.z());
  const double to_border_m = 0.5 * tiling.tile_m - own.head<2>().cwiseAbs().maxCoeff();
  return {own, shape, std::clamp(to_border_m / 2.0, 0.0, 1.0)};
}

double wall_octaves_m(const Eigen::Vector3d& p, std::uint64_t seed) {
  return 0.35 * noise_at(p, 9.0, seed) + 0.22 * noise_at(p, 3.5, seed + 1) + 0.14 * noise_at(p, 1.4, seed + 2) +
         0.05 * noise_at(p, 0.6, seed + 3);
}

double floor_octaves_m(const Eigen::Vector3d& p, std::uint64_t seed) {
  return 0.10 * noise_at(p, 6.0, seed + 4) + 0.05 * noise_at(p, 1.2, seed + 5);
}

double segment_distance_m(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double t = std::clamp((p - a).dot(b - a) / std::max((b - a).squaredNorm(), 1e-9), 0.0, 1.0);
  return (p - a - t * (b - a)).norm();
}

}  // namespace

Rock::Nearby Rock::nearby(const Eigen::Vector3d& centre, double radius_m) const {
  Nearby near;
  for (const Drift& drift : plan_->drifts) {
    const double reach = radius_m + reach_m + std::hypot(0.5 * drift.width_m, drift.height_m);
    for (std::size_t i = 0; i + 1 < drift.line.size(); ++i)
      if (segment_distance_m(centre, drift.line[i], drift.line[i + 1]) < reach)
        near.segments.push_back({&drift, drift.line[i], drift.line[i + 1]});
  }
  for (const Box& niche : plan_->niches)
    if ((niche.centre - centre).norm() < radius_m + reach_m + niche.half_size.norm()) near.niches.push_back(&niche);
  for (const Pile& pile : plan_->piles)
    if ((pile.foot - centre).norm() < radius_m + reach_m + pile.radius_m) near.piles.push_back(&pile);
  return near;
}

double Rock::depth_m(const Eigen::Vector3d& p, const Nearby& near) const {
  double wall_m = reach_m, floor_sum = 0, weight_sum = 1e-30;
  const Drift* previous = nullptr;
  double drift_m = reach_m;  // segments of one drift join without widening it at their ends
  for (const auto& segment : near.segments) {
    const Profile at = profile(p, segment);
    const double open_m = std::max(at.wall_m, at.floor_m - 1.0);
    if (segment.drift != previous) {
      wall_m = smooth_min(wall_m, drift_m, plan_->blend_m);
      drift_m = reach_m;
      previous = segment.drift;
    }
    if (open_m >= reach_m) continue;
    drift_m = std::min(drift_m, open_m);
    const double squared = (reach_m - open_m) * (reach_m - open_m), weight = squared * squared;
    floor_sum += weight * at.floor_m;
    weight_sum += weight;
  }
  wall_m = smooth_min(wall_m, drift_m, plan_->blend_m);
  for (const Box* niche : near.niches) wall_m = std::min(wall_m, box_depth_m(p, *niche));
  const double floor_m = weight_sum > 1e-20 ? floor_sum / weight_sum : reach_m;
  double depth = std::max(wall_m, floor_m);
  for (const Pile* pile : near.piles) depth = std::max(depth, cone_depth_m(p, *pile));
  if (plan_->roughness == 0 || std::abs(depth) > max_roughness_m) return depth;
  return depth + roughness_m(p, std::clamp(1.0 + 2.0 * (floor_m - wall_m), 0.0, 1.0));
}

double Rock::roughness_m(const Eigen::Vector3d& p, double floor_weight) const {
  const auto rough = [&](const Eigen::Vector3d& q, std::uint64_t seed) {
    double sum = 0;
    if (floor_weight < 1) sum += (1 - floor_weight) * wall_octaves_m(q, seed);
    if (floor_weight > 0) sum += floor_weight * floor_octaves_m(q, seed);
    return sum;
  };
  if (!plan_->tiling) return plan_->roughness * rough(p, plan_->rock_seed);
  const TilePlace tile = tile_place(*plan_->tiling, p);
  return plan_->roughness *
         (tile.fade * rough(tile.p, mix_bits(tile.shape)) + 0.04 * noise_at(p, 1.5, plan_->rock_seed));
}

}  // namespace headframe::mine
