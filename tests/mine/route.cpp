#include "tests/mine/route.hpp"

#include <algorithm>

namespace headframe::mine {
namespace {

/// Walks a polyline at equal steps from start_m on.
Route resampled(const std::vector<Eigen::Vector3d>& line, double start_m, double wanted_m) {
  Route route;
  double next_m = start_m, walked_m = 0;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const double piece_m = (line[i + 1] - line[i]).norm();
    while (next_m <= walked_m + piece_m && next_m <= start_m + wanted_m) {
      route.push_back(line[i] + (next_m - walked_m) / std::max(piece_m, 1e-9) * (line[i + 1] - line[i]));
      next_m += route_step_m;
    }
    walked_m += piece_m;
  }
  return route;
}

const Drift* drift_between(const Plan& plan, std::size_t a, std::size_t b) {
  for (const Drift& drift : plan.drifts)
    if ((drift.a == a && drift.b == b) || (drift.a == b && drift.b == a)) return &drift;
  return nullptr;
}

void follow(std::vector<Eigen::Vector3d>& line, const Drift& drift, std::size_t from) {
  if (drift.a == from)
    line.insert(line.end(), drift.line.begin(), drift.line.end());
  else
    line.insert(line.end(), drift.line.rbegin(), drift.line.rend());
}

double drift_length_m(const Drift& drift) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < drift.line.size(); ++i) sum += (drift.line[i + 1] - drift.line[i]).norm();
  return sum;
}

}  // namespace

Route route_through(const Plan& plan, const std::vector<std::size_t>& nodes, double start_m, double length_m) {
  std::vector<Eigen::Vector3d> line;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i)
    if (const Drift* drift = drift_between(plan, nodes[i], nodes[i + 1])) follow(line, *drift, nodes[i]);
  return resampled(line, start_m, length_m);
}

Route random_route(const Plan& plan, double length_m, Rng rng) {
  std::vector<bool> used(plan.drifts.size(), false);
  const Drift& first = plan.drifts[rng.index(plan.drifts.size())];
  std::size_t at = rng.chance(0.5) ? first.a : first.b;
  std::vector<Eigen::Vector3d> line;
  const double start_m = rng.uniform() * drift_length_m(first);
  double drawn_m = -start_m;
  const Drift* drift = &first;
  while (drift != nullptr) {
    follow(line, *drift, at);
    used[static_cast<std::size_t>(drift - plan.drifts.data())] = true;
    drawn_m += drift_length_m(*drift);
    at = drift->a == at ? drift->b : drift->a;
    if (drawn_m >= length_m) break;
    std::vector<const Drift*> onward;
    for (std::size_t i = 0; i < plan.drifts.size(); ++i)
      if (!used[i] && (plan.drifts[i].a == at || plan.drifts[i].b == at)) onward.push_back(&plan.drifts[i]);
    drift = onward.empty() ? nullptr : onward[rng.index(onward.size())];
  }
  return resampled(line, start_m, length_m);
}

double shared_part(const Route& route, const Route& other, double radius_m) {
  if (route.empty()) return 0;
  const auto near = [&](const Eigen::Vector3d& p) {
    return std::any_of(other.begin(), other.end(),
                       [&](const Eigen::Vector3d& q) { return (p - q).squaredNorm() < radius_m * radius_m; });
  };
  return static_cast<double>(std::count_if(route.begin(), route.end(), near)) / static_cast<double>(route.size());
}

double length_m(const Route& route) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < route.size(); ++i) sum += (route[i + 1] - route[i]).norm();
  return sum;
}

}  // namespace headframe::mine
