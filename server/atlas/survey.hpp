#pragma once
// Where a session lies in the mine's own grid, from a surveyor's control points. Pure. Grid coordinates are large (1e6
// m), so all numbers are doubles.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "server/atlas/atlas.hpp"

namespace headframe {

/// A mark in the mine whose position is known in both frames.
struct ControlPoint {
  std::string name;
  Eigen::Vector3d p_session_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_grid_m = Eigen::Vector3d::Zero();
};

struct Survey {
  SessionId session = 0;
  Pose T_grid_session = Pose::Identity();
  std::vector<ControlPoint> points;  // the points it was computed from; empty: it was given as a transform
};

/// What a survey has to satisfy.
struct SurveyRules {
  std::size_t least_points = 3, most_points = 1000;
  double least_width_m = 1.0;  // rms distance of the points from the line through them; below, the roll is undetermined
  double scale_tolerance = 0.02;     // of the distances in the grid relative to those in the session
  double most_tilt_rad = 0.175;      // 10 deg: sessions and the grid are both level
  double most_coordinate_m = 1e8;    // on each axis
  double orthonormal_within = 1e-3;  // of the rotation's columns: deviation from unit length and right angles
};

/// The rigid transform (no scale) that fits the points of the session to those of the grid by least squares. bad_input
/// says what is wrong with the points: too few, on a line, of another scale, mirrored, or not level.
Result<Pose> fit_survey(std::span<const ControlPoint> points, const SurveyRules& rules = {});

/// Checks a given transform and makes it orthonormal. bad_input: it is not rigid, or not level.
Result<Pose> checked_survey(const Eigen::Matrix4d& T_grid_session, const SurveyRules& rules = {});

/// Distance between each transformed point and its position in the grid, in metres.
std::vector<double> residuals_m(const Survey& survey);
/// Root mean square; 0 if empty.
double rms_m(std::span<const double> residuals_m);

/// T_grid_component from the survey of one of its sessions; of several, the last in the list (the one set last) is
/// used.
std::optional<Pose> grid_of(const Component& component, std::span<const Survey> surveys);

}  // namespace headframe
