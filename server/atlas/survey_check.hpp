#pragma once
// Whether control points fit each other, and which one does not. Pure.

#include "server/atlas/survey.hpp"

namespace headframe {

struct SurveyFitRules {
  double most_residual_m = 0.10;  // of a point, from its place in the grid ...
  double per_m = 0.002;   // ... and so much more for each metre that the points lie from their middle (rms): drift
  double told_m = 0.05;   // a point that is off by less is not called wrong
  double told_ratio = 3;  // ... nor one that is off by less than so many times what the others are
};

/// What a residual of these points may be.
double allowed_residual_m(std::span<const ControlPoint> points, const SurveyFitRules& rules = {});

/// The one point without which the others fit.
struct Blunder {
  std::size_t point = 0;
  Eigen::Vector3d off_m =
      Eigen::Vector3d::Zero();  // where the others put it, less where it was said to be, in the grid
  double others_rms_m = 0;
};

/// Leaves out each in turn. The session is taken to be level first (turn and shift only), for with four points any
/// three would fit by a tilt; when none stands out so, it may be tilted. None: there are fewer than four points, none
/// is told from the others, or all fit.
std::optional<Blunder> blunder_of(std::span<const ControlPoint> points, const SurveyFitRules& rules = {});

/// "P4 does not fit the others: they put it 2.00 m too high ...": for people.
std::string blunder_text(std::span<const ControlPoint> points, const Blunder& blunder);

/// refused when a residual is larger than allowed, or one point stands out by more than that though a tilt of the
/// session would hide it; with the blunder, where it can be told.
Result<void> check_fit(const Survey& survey, const SurveyFitRules& rules = {});

}  // namespace headframe
