#pragma once
// Where a session lies in the mine's own grid, as a surveyor found it. Pure. Grid coordinates are large (1e6 m):
// doubles.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "server/atlas/atlas.hpp"

namespace headframe {

/// A mark in the mine whose place is known in both frames.
struct ControlPoint {
  std::string name;
  Eigen::Vector3d p_session_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_grid_m = Eigen::Vector3d::Zero();
};

struct Survey {
  SessionId session = 0;
  Pose T_grid_session = Pose::Identity();
  std::vector<ControlPoint> points;  // that it was found from; none: it was given as a transform
};

/// What a survey has to keep to.
struct SurveyRules {
  std::size_t least_points = 3, most_points = 1000;
  double least_width_m = 1.0;        // rms distance of the points from the line through them, or the roll is a guess
  double scale_tolerance = 0.02;     // of the distances in the grid over those in the session
  double most_tilt_rad = 0.175;      // 10 deg: sessions and the grid are both level
  double most_coordinate_m = 1e8;    // of each axis
  double orthonormal_within = 1e-3;  // of the rotation's columns: length and right angles
};

/// The rigid transform (no scale) that lays the points of the session on those of the grid, by least squares.
/// bad_input says what is wrong with the points: too few, in a line, another scale, mirrored or on its side.
Result<Pose> fit_survey(std::span<const ControlPoint> points, const SurveyRules& rules = {});

/// A transform that was given: made orthonormal; bad_input when it is not rigid, or lays the session on its side.
Result<Pose> checked_survey(const Eigen::Matrix4d& T_grid_session, const SurveyRules& rules = {});

/// How far the survey puts each point from its place in the grid, in metres.
std::vector<double> residuals_m(const Survey& survey);
/// Root mean square; 0 without any.
double rms_m(std::span<const double> residuals_m);

/// T_grid_component by the survey of one of its sessions; of several the last in the list, the one set last, counts.
std::optional<Pose> grid_of(const Component& component, std::span<const Survey> surveys);

}  // namespace headframe
