#pragma once
// Made by tests/bench/fit_verdict.py on 2026-11-22 from 213 right and 593 wrong placements in 136 mines of 11 kinds.

#include <array>

namespace headframe {

inline constexpr double verdict_bias = 2.942;
inline constexpr std::array<double, 10> verdict_weights{5.401, 3.908, 0.524, 15.395, 0.000,
                                                        2.448, 0.000, 2.053, 0.823,  14.493};

}  // namespace headframe
