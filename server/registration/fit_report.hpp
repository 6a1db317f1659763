#pragma once

#include <vector>

#include "server/registration/normal_equations.hpp"

namespace headframe {

/// Sets all of the result except its pose, status and iterations. `distances_m`: the inliers' distances from their
/// planes.
void report_fit(Registration& result, const NormalEquations& sums, double source_points, double degenerate_below,
                std::vector<float> distances_m);

}  // namespace headframe
