#pragma once

#include <vector>

#include "server/registration/normal_equations.hpp"

namespace headframe {

/// Fills everything of the result but its pose, status and iterations. `distances_m`: of the inliers.
void report_fit(Registration& result, const NormalEquations& sums, double source_points, double degenerate_below,
                std::vector<float> distances_m);

}  // namespace headframe
