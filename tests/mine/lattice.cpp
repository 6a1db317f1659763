#include "tests/mine/lattice.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "tests/mine/noise.hpp"

namespace headframe::mine {
namespace {

using Edge = std::pair<std::size_t, std::size_t>;

double draw(Rng& rng, const Range& range) { return rng.uniform(range.low, range.high); }

std::vector<Eigen::Vector3d> lattice_nodes(const LatticeStyle& style, Rng rng) {
  std::vector<double> x(style.columns), y(style.rows);
  for (std::size_t i = 1; i < x.size(); ++i) x[i] = x[i - 1] + draw(rng, style.column_gap_m);
  for (std::size_t j = 1; j < y.size(); ++j) {
    const bool narrow = style.narrow_row_gap_m.high > 0 && j % 2 == 1;
    y[j] = y[j - 1] + draw(rng, narrow ? style.narrow_row_gap_m : style.row_gap_m);
  }
  const std::uint64_t wave_seed = rng.index(1u << 30);
  const double fall_rad = rng.uniform(0, 2 * std::numbers::pi);
  std::vector<Eigen::Vector3d> nodes;
  for (const double yj : y) {
    for (const double xi : x) {
      Eigen::Vector3d p(xi + style.jitter_m * rng.uniform(-1, 1), yj + 0.6 * style.jitter_m * rng.uniform(-1, 1), 0);
      p.z() = style.slope * (p.x() * std::cos(fall_rad) + p.y() * std::sin(fall_rad)) +
              style.waviness_m * noise_at(p, 40.0, wave_seed);
      nodes.push_back(p);
    }
  }
  return nodes;
}

std::vector<Edge> lattice_edges(const LatticeStyle& style, Rng rng) {
  std::vector<Edge> edges;
  for (std::size_t j = 0; j < style.rows; ++j) {
    for (std::size_t i = 0; i < style.columns; ++i) {
      const std::size_t k = j * style.columns + i;
      if (i + 1 < style.columns) edges.emplace_back(k, k + 1);
      if (j + 1 < style.rows) edges.emplace_back(k, k + style.columns);
    }
  }
  for (std::size_t i = edges.size(); i > 1; --i) std::swap(edges[i - 1], edges[rng.index(i)]);
  return edges;
}

std::size_t root(std::vector<std::size_t>& parent, std::size_t k) {
  while (parent[k] != k) k = parent[k] = parent[parent[k]];
  return k;
}

}  // namespace

void add_drift(Plan& plan, std::size_t a, std::size_t b, double bend, double width_m, double height_m) {
  const Eigen::Vector3d pa = plan.nodes[a], pb = plan.nodes[b], along = pb - pa;
  const Eigen::Vector3d sideways(-along.y(), along.x(), 0);
  const int steps = std::max(1, static_cast<int>(std::lround(along.norm() / 2.0)));
  Drift drift{a, b, {}, width_m, height_m};
  for (int i = 0; i <= (bend == 0 ? 1 : steps); ++i) {
    const double t = bend == 0 ? i : static_cast<double>(i) / steps;
    drift.line.push_back(pa + t * along + bend * std::sin(std::numbers::pi * t) * sideways);
  }
  plan.drifts.push_back(std::move(drift));
}

Plan lattice_plan(const LatticeStyle& style, Rng rng) {
  Plan plan;
  plan.nodes = lattice_nodes(style, rng.fork(1));
  std::vector<std::size_t> parent(plan.nodes.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  Rng pick = rng.fork(3);
  for (const auto& [a, b] : lattice_edges(style, rng.fork(2))) {
    const std::size_t ra = root(parent, a), rb = root(parent, b);
    const bool keep = pick.chance(style.keep);
    const double bend = style.bend * pick.uniform(-1, 1);
    const double width_m = draw(pick, style.width_m), height_m = draw(pick, style.height_m);
    if (ra == rb && !keep) continue;
    parent[ra] = rb;
    add_drift(plan, a, b, bend, width_m, std::min(height_m, 0.95 * width_m));
  }
  return plan;
}

}  // namespace headframe::mine
