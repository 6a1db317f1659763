#include "server/atlas/survey.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace headframe {
namespace {

tl::unexpected<Error> no_survey(const std::string& why) { return failure(ErrorCode::bad_input, "the survey: " + why); }

std::string fixed(const char* format, double value) {
  std::array<char, 64> text;
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

using Matrix3X = Eigen::Matrix3Xd;

/// Points as columns, without their mean.
struct Centred {
  Eigen::Vector3d mean;
  Matrix3X points;
  explicit Centred(Matrix3X all) : mean(all.rowwise().mean()), points(std::move(all)) { points.colwise() -= mean; }
  double rms() const { return std::sqrt(points.squaredNorm() / static_cast<double>(points.cols())); }
  /// Rms distance from the line that fits best.
  double width() const {
    const Eigen::Vector3d squares =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(points * points.transpose()).eigenvalues();
    return std::sqrt(std::max(0.0, squares[0] + squares[1]) / static_cast<double>(points.cols()));
  }
};

Result<Pose> upright(const Pose& T, const SurveyRules& rules) {
  const double tilt = tilt_rad(T);
  if (tilt <= rules.most_tilt_rad) return T;
  return no_survey("it would tilt the level session by " + fixed("%.0f", tilt * 180 / M_PI) +
                   " deg; are easting and northing swapped, or is z not up?");
}

Result<void> check_numbers(std::span<const ControlPoint> points, const SurveyRules& rules) {
  for (const ControlPoint& point : points)
    for (const auto& p : {point.p_session_m, point.p_grid_m})
      if (!p.allFinite() || p.cwiseAbs().maxCoeff() > rules.most_coordinate_m)
        return no_survey("point \"" + point.name + "\" has a coordinate beyond " +
                         fixed("%.0f", rules.most_coordinate_m) + " m");
  if (points.size() < rules.least_points || points.size() > rules.most_points)
    return no_survey(std::to_string(points.size()) + " points; give " + std::to_string(rules.least_points) + " to " +
                     std::to_string(rules.most_points));
  return {};
}

Result<void> check_shape(const Centred& session, const Centred& grid, const SurveyRules& rules) {
  const double width_m = std::min(session.width(), grid.width());
  if (width_m < rules.least_width_m)
    return no_survey("the points lie in a line, to within " + fixed("%.2f", width_m) +
                     " m: the turn about it is open; add a point at least a few metres beside it");
  const double scale = grid.rms() / session.rms();
  if (std::abs(scale - 1) > rules.scale_tolerance)
    return no_survey("distances in the grid are " + fixed("%.4f", scale) +
                     " times those in the session; are both in metres, and does each point have its own name?");
  return {};
}

}  // namespace

Result<Pose> fit_survey(std::span<const ControlPoint> points, const SurveyRules& rules) {
  if (auto good = check_numbers(points, rules); !good) return tl::unexpected(good.error());
  Matrix3X in_session(3, points.size()), in_grid(3, points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    in_session.col(static_cast<Eigen::Index>(i)) = points[i].p_session_m;
    in_grid.col(static_cast<Eigen::Index>(i)) = points[i].p_grid_m;
  }
  const Centred session(std::move(in_session)), grid(std::move(in_grid));
  if (auto good = check_shape(session, grid, rules); !good) return tl::unexpected(good.error());
  // Kabsch: of the rotations, not of the reflections, the one that makes the squared distances least.
  const Eigen::Matrix3d H = session.points * grid.points.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double hand = (svd.matrixV() * svd.matrixU().transpose()).determinant();
  const Eigen::Vector3d keep(1, 1, hand < 0 ? -1 : 1);
  Pose T = Pose::Identity();
  T.linear() = svd.matrixV() * keep.asDiagonal() * svd.matrixU().transpose();
  T.translation() = grid.mean - T.linear() * session.mean;
  return upright(T, rules);
}

Result<Pose> checked_survey(const Eigen::Matrix4d& matrix, const SurveyRules& rules) {
  if (!matrix.allFinite() || matrix.topRightCorner<3, 1>().cwiseAbs().maxCoeff() > rules.most_coordinate_m)
    return no_survey("T_grid_session has a number that is not finite, or a place beyond " +
                     fixed("%.0f", rules.most_coordinate_m) + " m");
  const Eigen::Matrix3d R = matrix.topLeftCorner<3, 3>();
  const double off = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  const bool last_row = matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1));
  if (off > rules.orthonormal_within || R.determinant() < 0 || !last_row)
    return no_survey(
        "T_grid_session is no rigid transform (16 numbers, row-major, a rotation without scale or mirror)");
  Pose T;
  T.matrix() = matrix;
  return upright(orthonormalised(T), rules);
}

std::vector<double> residuals_m(const Survey& survey) {
  std::vector<double> out;
  out.reserve(survey.points.size());
  for (const ControlPoint& point : survey.points)
    out.push_back((survey.T_grid_session * point.p_session_m - point.p_grid_m).norm());
  return out;
}

double rms_m(std::span<const double> residuals) {
  double squares = 0;
  for (const double r : residuals) squares += r * r;
  return residuals.empty() ? 0 : std::sqrt(squares / static_cast<double>(residuals.size()));
}

std::optional<Pose> grid_of(const Component& component, std::span<const Survey> surveys) {
  for (auto survey = surveys.rbegin(); survey != surveys.rend(); ++survey)
    for (const Placement& placement : component.placements)
      if (placement.session == survey->session) return survey->T_grid_session * placement.T_component_session.inverse();
  return std::nullopt;
}

}  // namespace headframe
