#include "tests/mine/plan.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "tests/mine/lattice.hpp"

namespace headframe::mine {
namespace {

constexpr std::array<std::pair<std::string_view, Kind>, 8> kind_names{{{"junctions", Kind::junctions},
                                                                       {"grid", Kind::grid},
                                                                       {"room_and_pillar", Kind::room_and_pillar},
                                                                       {"ramp", Kind::ramp},
                                                                       {"straight", Kind::straight},
                                                                       {"look_alike", Kind::look_alike},
                                                                       {"varied", Kind::varied},
                                                                       {"tiled_cave", Kind::tiled_cave}}};

Plan junctions_plan(Rng rng) {
  return lattice_plan({.columns = 6,
                       .rows = 6,
                       .column_gap_m = {24, 40},
                       .row_gap_m = {26, 40},
                       .narrow_row_gap_m = {12, 20},
                       .jitter_m = 4,
                       .keep = 0.55,
                       .bend = 0.12,
                       .width_m = {3, 7},
                       .height_m = {2.8, 4.6},
                       .slope = 0.02,
                       .waviness_m = 1.5},
                      rng);
}

Plan grid_plan(Rng rng) {
  const double width_m = rng.uniform(4, 5.5);
  return lattice_plan({.columns = 8,
                       .rows = 9,
                       .column_gap_m = {26, 26},
                       .row_gap_m = {18, 18},
                       .keep = 1,
                       .width_m = {width_m, width_m}},
                      rng);
}

Plan room_and_pillar_plan(Rng rng) {
  return lattice_plan({.columns = 13,
                       .rows = 13,
                       .column_gap_m = {12, 15},
                       .row_gap_m = {12, 15},
                       .jitter_m = 0.8,
                       .keep = 0.95,
                       .width_m = {5.5, 9},
                       .height_m = {2.8, 3.6},
                       .waviness_m = 0.8},
                      rng);
}

/// Anything from a narrow vein to a haulage level: every figure is drawn, for the whole mine.
Plan varied_plan(Rng rng) {
  const double width_m = rng.uniform(2.5, 8), height_m = width_m * rng.uniform(0.5, 0.85);
  const double gap_m = std::max(12.0, 2.2 * width_m) + rng.uniform(0, 22);
  LatticeStyle style{.columns = 4 + rng.index(3), .rows = 4 + rng.index(3)};
  style.column_gap_m = {gap_m, gap_m * rng.uniform(1, 1.6)};
  style.row_gap_m = {gap_m, gap_m * rng.uniform(1, 1.6)};
  style.jitter_m = 0.2 * gap_m * rng.uniform();
  style.keep = rng.uniform(0.3, 1);
  style.bend = 0.2 * rng.uniform();
  style.width_m = {width_m, width_m * rng.uniform(1, 1.5)};
  style.height_m = {std::max(2.0, height_m), std::max(2.0, height_m) * rng.uniform(1, 1.3)};
  style.slope = 0.06 * rng.uniform();
  style.waviness_m = 1.5 * rng.uniform();
  const double roughness = rng.uniform(0.15, 1.6);
  Plan plan = lattice_plan(style, rng);
  plan.roughness = roughness;
  return plan;
}

/// One long smooth drift, its twin beside it, joined by two cross-cuts only.
Plan straight_plan(Rng rng) {
  Plan plan;
  const double gap_m = rng.uniform(12, 20), width_m = rng.uniform(4, 7);
  constexpr std::size_t stations = 8;
  for (std::size_t row = 0; row < 2; ++row)
    for (std::size_t i = 0; i < stations; ++i)
      plan.nodes.emplace_back(35.0 * static_cast<double>(i), gap_m * static_cast<double>(row), 0);
  const double bend = rng.uniform(-0.01, 0.01);
  for (std::size_t row = 0; row < 2; ++row)
    for (std::size_t i = 0; i + 1 < stations; ++i)
      add_drift(plan, row * stations + i, row * stations + i + 1, bend, width_m, 0.75 * width_m);
  for (const std::size_t i : {rng.index(3), 4 + rng.index(4)})
    add_drift(plan, i, stations + i, 0, width_m, 0.7 * width_m);
  plan.roughness = 0.3;
  plan.blend_m = 0.1;  // a joint may not show
  return plan;
}

void append(Plan& plan, const Plan& other) {
  const std::size_t first = plan.nodes.size();
  plan.nodes.insert(plan.nodes.end(), other.nodes.begin(), other.nodes.end());
  for (Drift drift : other.drifts) {
    drift.a += first;
    drift.b += first;
    plan.drifts.push_back(std::move(drift));
  }
}

/// Three levels, 12 m apart, on one spiral ramp.
Plan ramp_plan(Rng rng) {
  constexpr int levels = 3, turn_steps = 12;
  constexpr double rise_m = 12, radius_m = 13;
  Plan plan;
  const double width_m = rng.uniform(4.5, 6);
  for (int i = 0; i <= (levels - 1) * turn_steps; ++i) {
    const double angle = 2 * std::numbers::pi * i / turn_steps;
    plan.nodes.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle), rise_m * i / turn_steps);
    if (i > 0) add_drift(plan, plan.nodes.size() - 2, plan.nodes.size() - 1, -0.065, width_m, 4);
  }
  for (int level = 0; level < levels; ++level) {
    const LatticeStyle style{.columns = 4,
                             .rows = 4,
                             .column_gap_m = {26, 38},
                             .row_gap_m = {16, 34},
                             .jitter_m = 3,
                             .keep = 0.5,
                             .bend = 0.08,
                             .width_m = {3.5, 6.5},
                             .height_m = {3, 4.2}};
    const std::size_t station = plan.nodes.size();
    append(plan,
           moved(lattice_plan(style, rng.fork(10 + static_cast<std::uint64_t>(level))), {32, -40, rise_m * level}));
    add_drift(plan, static_cast<std::size_t>(level) * turn_steps, station + 4, 0, width_m, 4);
  }
  return plan;
}

/// 20 m tiles as a robot competition builds its tunnels: every tile of a shape is the same piece.
Plan look_alike_plan(Rng rng) {
  Plan plan = lattice_plan({.columns = 9,
                            .rows = 9,
                            .column_gap_m = {20, 20},
                            .row_gap_m = {20, 20},
                            .keep = 0.25,
                            .width_m = {5, 5},
                            .height_m = {3.6, 3.6}},
                           rng);
  Tiling tiling{.columns = 9, .open = std::vector<std::uint8_t>(81, 0), .pieces = {}};
  for (const Drift& drift : plan.drifts) {  // a is left of b or below it
    const bool upward = drift.b - drift.a != 1;
    tiling.open[drift.a] |= upward ? 2 : 1;
    tiling.open[drift.b] |= upward ? 8 : 4;
  }
  plan.tiling = tiling;
  plan.roughness = 0.8;
  return plan;
}

/// Widens the tunnels about a tile's centre into rooms, with gravel at their walls: the same for every tile of a piece.
void add_rooms(Plan& plan, const Eigen::Vector3d& centre, const TilePiece& piece) {
  Rng own(mix_bits(piece_seed + piece.number));
  for (int i = 0; i < 3; ++i) {
    const double axis_rad = 0.5 * std::numbers::pi * static_cast<double>(piece.quarter_turns + own.index(2));
    const Eigen::Vector3d along(std::cos(axis_rad), std::sin(axis_rad), 0), left(-along.y(), along.x(), 0);
    const Eigen::Vector3d half_size(own.uniform(2, 4), own.uniform(2.4, 4), own.uniform(1.2, 1.9));
    const Eigen::Vector3d foot = centre + own.uniform(-5, 5) * along + own.uniform(-1, 1) * left;
    plan.niches.push_back({foot + Eigen::Vector3d(0, 0, half_size.z()), half_size, axis_rad + own.uniform(-0.3, 0.3)});
    const double radius_m = own.uniform(0.7, 1.5), side = own.chance(0.5) ? 1 : -1;
    plan.piles.push_back({foot + side * 3 * left, radius_m, radius_m * own.uniform(0.5, 0.9)});
  }
}

/// A natural cave as a robot competition builds it: pieces of 20 m, open to all sides, any of them at any heading.
Plan tiled_cave_plan(Rng rng) {
  constexpr std::size_t side = 8, pieces = 7;
  Plan plan = lattice_plan({.columns = side,
                            .rows = side,
                            .column_gap_m = {20, 20},
                            .row_gap_m = {20, 20},
                            .keep = 1,
                            .width_m = {4.5, 4.5},
                            .height_m = {3.6, 3.6}},
                           rng);
  Tiling tiling{.columns = side, .open = std::vector<std::uint8_t>(side * side, 15), .pieces = {}};
  for (const auto& node : plan.nodes) {
    tiling.pieces.push_back({static_cast<std::uint8_t>(rng.index(pieces)), static_cast<std::uint8_t>(rng.index(4))});
    add_rooms(plan, node, tiling.pieces.back());
  }
  plan.tiling = std::move(tiling);
  return plan;
}

}  // namespace

std::optional<Kind> kind_of(std::string_view name) {
  for (const auto& [kind_name, kind] : kind_names)
    if (kind_name == name) return kind;
  return std::nullopt;
}

std::string_view to_string(Kind kind) {
  for (const auto& [kind_name, k] : kind_names)
    if (k == kind) return kind_name;
  return "unknown";
}

std::string kind_list() {
  std::string names;
  for (const auto& [name, kind] : kind_names) (names += names.empty() ? "" : ", ") += name;
  return names;
}

Plan make_plan(Kind kind, std::uint64_t seed) {
  const Rng rng = Rng(seed).fork(static_cast<std::uint64_t>(kind));
  const auto build = [&] {
    switch (kind) {
      case Kind::junctions: return junctions_plan(rng);
      case Kind::grid: return grid_plan(rng);
      case Kind::room_and_pillar: return room_and_pillar_plan(rng);
      case Kind::ramp: return ramp_plan(rng);
      case Kind::straight: return straight_plan(rng);
      case Kind::look_alike: return look_alike_plan(rng);
      case Kind::varied: return varied_plan(rng);
      case Kind::tiled_cave: return tiled_cave_plan(rng);
    }
    return Plan{};
  };
  Plan plan = build();
  plan.rock_seed = mix_bits(seed);
  if (!plan.tiling) furnish(plan, rng.fork(99));
  return plan;
}

Plan moved(Plan plan, const Eigen::Vector3d& offset_m) {
  for (auto& p : plan.nodes) p += offset_m;
  for (auto& drift : plan.drifts)
    for (auto& p : drift.line) p += offset_m;
  for (auto& box : plan.niches) box.centre += offset_m;
  for (auto& box : plan.vehicles) box.centre += offset_m;
  for (auto& pile : plan.piles) pile.foot += offset_m;
  for (auto& pipe : plan.pipes)
    for (auto& p : pipe.line) p += offset_m;
  if (plan.tiling) plan.tiling->origin += offset_m;
  return plan;
}

}  // namespace headframe::mine
