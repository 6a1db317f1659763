#pragma once

#include "server/verification/evidence.hpp"

namespace headframe::test {

/// Of a placement that all speaks for: 36 m are shared, and six places agree.
inline Evidence convincing() {
  Evidence e;
  e.pairs = 12;
  e.places = e.places_agreeing = 6;
  e.inlier_fraction = 0.8;
  e.matched_share = 0.9;
  e.residual_m = 0.02;
  e.overlap_m = 36;
  e.weakest_hold = 0.1;
  return e;
}

}  // namespace headframe::test
