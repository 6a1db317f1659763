#pragma once

#include "server/verification/evidence.hpp"

namespace headframe::test {

/// Of a placement that all speaks for: 36 m are shared, six places agree, the walls match far to the sides, and both
/// saw much of the rock.
inline Evidence convincing() {
  Evidence e;
  e.pairs = 12;
  e.places = e.places_agreeing = 6;
  e.inlier_fraction = 0.8;
  e.matched_share = 0.9;
  e.residual_m = 0.02;
  e.rmse_m = 0.09;
  e.own_scatter_m = 0.06;
  e.overlap_m = 36;
  e.weakest_hold = 0.1;
  e.end_on_match = 0.5;
  e.descriptors_compared = 8;
  e.descriptors_alike = 0.88;
  e.support = 300;
  e.rock_in_common = 1200;
  return e;
}

}  // namespace headframe::test
