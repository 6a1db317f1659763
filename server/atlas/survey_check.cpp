#include "server/atlas/survey_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace headframe {
namespace {

std::string metres(double value) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.2f m", value);
  return text.data();
}

/// Turn about the vertical and shift, by least squares.
Pose level_fit(std::span<const ControlPoint> points) {
  Eigen::Vector3d session = Eigen::Vector3d::Zero(), grid = Eigen::Vector3d::Zero();
  for (const ControlPoint& point : points) session += point.p_session_m, grid += point.p_grid_m;
  session /= static_cast<double>(points.size()), grid /= static_cast<double>(points.size());
  double along = 0, across = 0;
  for (const ControlPoint& point : points) {
    const Eigen::Vector3d s = point.p_session_m - session, g = point.p_grid_m - grid;
    along += s.x() * g.x() + s.y() * g.y();
    across += s.x() * g.y() - s.y() * g.x();
  }
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(std::atan2(across, along), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = grid - T.linear() * session;
  return T;
}

std::optional<Pose> tilted_fit(std::span<const ControlPoint> points) {
  const auto T = fit_survey(points);
  return T ? std::optional(*T) : std::nullopt;
}

/// The blunder by one kind of fit; nullopt if leaving out one point fits about as well as leaving out another.
template <class Fit>
std::optional<Blunder> left_out(std::span<const ControlPoint> points, double fits_m, Fit fit) {
  std::optional<Blunder> best;
  double next_rms_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::vector<ControlPoint> others(points.begin(), points.end());
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const std::optional<Pose> T = fit(others);
    if (!T) continue;
    const double others_rms_m = rms_m(residuals_m({0, *T, others}));
    if (best && others_rms_m >= best->others_rms_m) {
      next_rms_m = std::min(next_rms_m, others_rms_m);
      continue;
    }
    if (best) next_rms_m = best->others_rms_m;
    best = Blunder{i, *T * points[i].p_session_m - points[i].p_grid_m, others_rms_m};
  }
  const bool told = best && best->others_rms_m <= fits_m && next_rms_m > 2 * best->others_rms_m;
  return told ? best : std::nullopt;
}

}  // namespace

double allowed_residual_m(std::span<const ControlPoint> points, const SurveyFitRules& rules) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const ControlPoint& point : points) middle += point.p_session_m / static_cast<double>(points.size());
  double squares = 0;
  for (const ControlPoint& point : points) squares += (point.p_session_m - middle).squaredNorm();
  return rules.most_residual_m +
         rules.per_m * std::sqrt(squares / static_cast<double>(std::max<std::size_t>(points.size(), 1)));
}

std::optional<Blunder> blunder_of(std::span<const ControlPoint> points, const SurveyFitRules& rules) {
  if (points.size() < 4) return std::nullopt;
  const double fits_m = allowed_residual_m(points, rules);
  auto found = left_out(points, fits_m, [](const auto& others) { return std::optional(level_fit(others)); });
  // If all points fit a level session, none is far wrong, and a tilt would only be guessed from the few that are left.
  const std::vector<double> level_m = residuals_m({0, level_fit(points), {points.begin(), points.end()}});
  const bool level = *std::max_element(level_m.begin(), level_m.end()) <= fits_m;
  if (!found && !level) found = left_out(points, fits_m, [](const auto& others) { return tilted_fit(others); });
  if (!found || found->off_m.norm() < std::max(rules.told_m, rules.told_ratio * found->others_rms_m))
    return std::nullopt;
  return found;
}

std::string blunder_text(std::span<const ControlPoint> points, const Blunder& blunder) {
  const std::array<std::array<const char*, 2>, 3> sides{{{"east", "west"}, {"north", "south"}, {"above", "below"}}};
  std::string where;
  for (int axis = 0; axis < 3; ++axis) {
    const double off_m = blunder.off_m[axis];
    if (std::abs(off_m) < 0.1 * blunder.off_m.norm()) continue;
    where += (where.empty() ? "" : ", ") + metres(std::abs(off_m)) + " " +
             sides.at(static_cast<std::size_t>(axis)).at(off_m > 0 ? 0 : 1);
  }
  return points[blunder.point].name + " is likely wrong: without it the others fit within " +
         metres(blunder.others_rms_m) + " (rms), and put it " + where + " the place that was given";
}

Result<void> check_fit(const Survey& survey, const SurveyFitRules& rules) {
  const std::vector<double> residuals = residuals_m(survey);
  if (residuals.empty()) return {};
  const auto worst = std::max_element(residuals.begin(), residuals.end());
  const double allowed_m = allowed_residual_m(survey.points, rules);
  const auto blunder = blunder_of(survey.points, rules);
  // With few points a tilt of the whole session can hide a wrong one, so residuals alone do not show it.
  const bool hidden = blunder && blunder->off_m.norm() > allowed_m;
  if (*worst <= allowed_m && !hidden) return {};
  const std::string name = survey.points[static_cast<std::size_t>(worst - residuals.begin())].name;
  const std::string fault = *worst <= allowed_m
                                ? "the points fit each other by tilting the session only"
                                : "the points do not fit each other: " + name + " would be off by " + metres(*worst) +
                                      ", and " + metres(allowed_m) + " is the most for points this far apart";
  const std::string why = blunder ? blunder_text(survey.points, *blunder) + "; mend it or leave it out"
                          : survey.points.size() < 4 ? "with three points the wrong one can not be told: add a fourth"
                                                     : "which of them is wrong can not be told: check all";
  return failure(ErrorCode::refused, "the survey: " + fault + "; " + why + ", or say that it is to stand all the same");
}

}  // namespace headframe
