#pragma once
// Whether control points are consistent, and which one is not. Pure.

#include "server/atlas/survey.hpp"

namespace headframe {

struct SurveyFitRules {
  double most_residual_m = 0.10;  // of a point from its position in the grid ...
  double per_m = 0.002;           // ... plus this for each metre of the points' rms distance from their mean, for drift
  double told_m = 0.05;           // a point that is off by less is not called wrong
  double told_ratio = 3;          // nor one that is off by less than this many times the others
};

/// The greatest residual that these points may have.
double allowed_residual_m(std::span<const ControlPoint> points, const SurveyFitRules& rules = {});

/// The one point without which the others fit.
struct Blunder {
  std::size_t point = 0;
  Eigen::Vector3d off_m =
      Eigen::Vector3d::Zero();  // where the others put it, less where it was said to be, in the grid
  double others_rms_m = 0;
};

/// Leaves out each point in turn. First assumes a level session (yaw and translation only), because with four points
/// any three would fit after a tilt; if no point stands out, a tilt is allowed. Nullopt: there are fewer than four
/// points, no point stands out, or all fit.
std::optional<Blunder> blunder_of(std::span<const ControlPoint> points, const SurveyFitRules& rules = {});

/// A message for people: "P4 is likely wrong: without it the others fit within ... (rms), and put it ... above the
/// place that was given".
std::string blunder_text(std::span<const ControlPoint> points, const Blunder& blunder);

/// refused: a residual is larger than allowed, or one point stands out by more than that although a tilt of the session
/// would hide it; the message names the blunder if it can be identified.
Result<void> check_fit(const Survey& survey, const SurveyFitRules& rules = {});

}  // namespace headframe
