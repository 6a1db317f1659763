#pragma once

#include <span>

#include "server/registration/submap.hpp"

namespace headframe {

/// How the points of one session look from the sweeps of another. A lone point that rays pass through is dust or the
/// edge of something; rock that is not there makes patches. So a violation counts when three more lie within 0.9 m of
/// it.
struct Visibility {
  double seen = 0;      // points that lie on a surface the sweeps met
  double violated = 0;  // points that the sweeps' rays went through
  double lone = 0;      // violations that stand alone
  double unknown = 0;   // neither: hidden, out of range, outside the field of view
  Visibility& operator+=(const Visibility& other);
  double violation() const { return seen + violated > 0 ? violated / (seen + violated) : 0; }
};

/// points_b in b's local frame, viewed from a's sweeps, up to reach_m.
Visibility look_from(std::span<const PlacedCloud> a, const Points& points_b, const Pose& T_a_b, float reach_m,
                     int threads);

}  // namespace headframe
