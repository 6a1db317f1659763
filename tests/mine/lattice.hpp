#pragma once
// Networks of drifts grown on a lattice: jitter, bends and missing drifts turn it into anything from a grid to a maze.

#include "tests/mine/plan.hpp"

namespace headframe::mine {

struct Range {
  double low = 0;
  double high = 0;
};

struct LatticeStyle {
  std::size_t columns = 6;
  std::size_t rows = 6;
  Range column_gap_m{24, 24};
  Range row_gap_m{18, 18};
  Range narrow_row_gap_m{0, 0};  // every second row gap, where given: parallel drifts
  double jitter_m = 0;
  double keep = 1;  // share of the drifts that are not needed to stay connected
  double bend = 0;  // sideways bend of a drift over its length
  Range width_m{4.5, 4.5};
  Range height_m{3.5, 3.5};
  double slope = 0;       // of the floor over the whole mine
  double waviness_m = 0;  // floor: rises and falls by this over about 40 m
};

/// Connected for every style.
Plan lattice_plan(const LatticeStyle& style, Rng rng);

/// Adds a drift between two nodes, bent sideways by bend * length, sampled every 2 m.
void add_drift(Plan& plan, std::size_t a, std::size_t b, double bend, double width_m, double height_m);

}  // namespace headframe::mine
