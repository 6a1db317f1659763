// What makes one drift differ from the next: pipes, vehicles, niches, gravel.

#include <algorithm>
#include <cmath>

#include "tests/mine/plan.hpp"

namespace headframe::mine {
namespace {

struct Station {
  Eigen::Vector3d p;     // on the floor, in the middle
  Eigen::Vector3d left;  // unit
  double yaw_rad;
};

/// Somewhere along the drift, away from its ends.
Station station(const Drift& drift, double share) {
  const auto last = static_cast<double>(drift.line.size() - 1);
  const double at = std::clamp(share * last, 0.0, last - 1e-6);
  const auto i = static_cast<std::size_t>(at);
  const Eigen::Vector3d along = drift.line[i + 1] - drift.line[i];
  const double yaw_rad = std::atan2(along.y(), along.x());
  return {drift.line[i] + (at - static_cast<double>(i)) * along, {-std::sin(yaw_rad), std::cos(yaw_rad), 0}, yaw_rad};
}

void add_pipe(Plan& plan, const Drift& drift, Rng& rng) {
  const double side = rng.chance(0.5) ? 1 : -1;
  const double offset_m = side * (0.5 * drift.width_m - 0.5), height_m = std::min(0.55 * drift.height_m, 2.2);
  Pipe pipe{.line = {}, .radius_m = rng.uniform(0.1, 0.3)};
  const double low = rng.uniform(0.1, 0.3), high = rng.uniform(0.6, 0.9);
  for (int i = 0; i <= 8; ++i) {
    const Station s = station(drift, low + (high - low) * i / 8);
    pipe.line.push_back(s.p + offset_m * s.left + Eigen::Vector3d(0, 0, height_m));
  }
  plan.pipes.push_back(std::move(pipe));
}

void add_vehicle(Plan& plan, const Drift& drift, Rng& rng) {
  const Station s = station(drift, rng.uniform(0.3, 0.7));
  const double side = rng.chance(0.5) ? 1 : -1;
  const Eigen::Vector3d half(rng.uniform(1.2, 2.6), 0.7, rng.uniform(0.6, 0.9));
  const Eigen::Vector3d centre =
      s.p + side * (0.5 * drift.width_m - 0.6) * s.left + Eigen::Vector3d(0, 0, half.z() + 0.3);
  plan.vehicles.push_back({centre, half, s.yaw_rad});
  const Eigen::Vector3d forward(std::cos(s.yaw_rad), std::sin(s.yaw_rad), 0);
  plan.vehicles.push_back(
      {centre + 0.5 * half.x() * forward + Eigen::Vector3d(0, 0, half.z() + 0.3), {0.6, 0.6, 0.3}, s.yaw_rad});
}

void add_niche(Plan& plan, const Drift& drift, Rng& rng) {
  const Station s = station(drift, rng.uniform(0.2, 0.8));
  const double side = rng.chance(0.5) ? 1 : -1;
  const Eigen::Vector3d half(rng.uniform(0.8, 2.5), rng.uniform(1, 2.5), rng.uniform(0.9, 1.3));
  plan.niches.push_back({s.p + side * 0.5 * drift.width_m * s.left + Eigen::Vector3d(0, 0, half.z()), half, s.yaw_rad});
}

void add_pile(Plan& plan, const Drift& drift, Rng& rng) {
  const Station s = station(drift, rng.uniform(0.15, 0.85));
  const double side = rng.chance(0.5) ? 1 : -1;
  const double radius_m = std::min(rng.uniform(0.8, 2.2), 0.5 * drift.width_m - 0.6);
  plan.piles.push_back({s.p + side * 0.5 * drift.width_m * s.left, radius_m, radius_m * rng.uniform(0.5, 0.8)});
}

}  // namespace

void furnish(Plan& plan, Rng rng) {
  const double density = plan.roughness;  // a smooth drift is an empty one
  for (const Drift& drift : plan.drifts) {
    const double length_m = (drift.line.back() - drift.line.front()).norm();
    if (length_m < 10) continue;
    if (rng.chance(0.3 * density)) add_pipe(plan, drift, rng);
    if (drift.width_m > 4.4 && rng.chance(0.25 * density)) add_vehicle(plan, drift, rng);
    if (rng.chance(0.4 * density)) add_niche(plan, drift, rng);
    if (rng.chance(0.6 * density)) add_pile(plan, drift, rng);
  }
}

}  // namespace headframe::mine
