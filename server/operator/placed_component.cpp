#include "server/operator/placed_component.hpp"

#include <algorithm>
#include <map>
#include <sstream>

namespace headframe {
namespace {

/// A robot's coordinates may have a distant origin (UTM); then the component that it anchors is far from its origin
/// too.
Eigen::Vector3d origin_near(const Eigen::Vector3d& p_m) {
  constexpr double near_m = 10e3;  // up to there single precision resolves a millimetre
  if (p_m.cwiseAbs().maxCoeff() < near_m) return Eigen::Vector3d::Zero();
  return p_m.array().round();
}

/// T_grid_component for a session that the pose graph corrects: the survey is fitted again with its control points
/// moved as the keyframe nearest to each was moved.
std::optional<Pose> grid_of_bent(const Station& station, const Correction& correction, const Survey& survey) {
  if (survey.points.empty()) return survey.T_grid_session * correction.keyframes.front().T_component_session.inverse();
  const auto keyframes = station.trajectory(survey.session);
  if (!keyframes || keyframes->empty()) return std::nullopt;
  std::vector<ControlPoint> points = survey.points;
  for (ControlPoint& point : points) {
    const auto far = [&](const Keyframe& k) {
      return (k.T_local_sensor.translation() - point.p_session_m).squaredNorm();
    };
    const auto nearest = std::min_element(keyframes->begin(), keyframes->end(),
                                          [&](const Keyframe& k, const Keyframe& l) { return far(k) < far(l); });
    point.p_session_m = correction.corrected(nearest->sequence, nearest->T_local_sensor) *
                        (nearest->T_local_sensor.inverse() * point.p_session_m);
  }
  const auto T_grid_component = fit_survey(points);
  return T_grid_component ? std::optional(*T_grid_component) : std::nullopt;
}

}  // namespace

Result<OutputFrame> output_frame_from(const std::string& name) {
  if (name == "component") return OutputFrame::component;
  if (name == "grid") return OutputFrame::grid;
  return failure(ErrorCode::invalid_argument, "parameter \"frame\" is \"" + name + "\"; give component or grid");
}

Result<Component> find_component(const Atlas& atlas, SessionId id) {
  std::ostringstream there;
  for (const Component& component : atlas.components) {
    if (component.id == id) return component;
    there << (there.tellp() > 0 ? ", " : "") << component.id;
  }
  const std::string list = there.str();
  return failure(ErrorCode::not_found, "there is no component " + std::to_string(id) +
                                           (list.empty() ? "; the atlas is empty" : "; there are " + list));
}

Result<Pose> frame_of(const Station& station, const Component& component, OutputFrame frame) {
  if (frame == OutputFrame::component) return Pose::Identity();
  const std::vector<Survey> surveys = station.surveys();
  const auto of_component = [&](const Survey& survey) { return placement_in(component, survey.session) != nullptr; };
  const auto survey = std::find_if(surveys.rbegin(), surveys.rend(), of_component);  // the one set last
  if (survey != surveys.rend()) {
    const Corrections corrections = station.atlas().corrections;
    const auto bent = corrections.find(survey->session);
    if (bent != corrections.end())
      if (const auto T_grid_component = grid_of_bent(station, *bent->second, *survey)) return *T_grid_component;
  }
  if (const auto T_grid_component = grid_of(component, surveys)) return *T_grid_component;
  return failure(ErrorCode::not_found, "no session of component " + std::to_string(component.id) +
                                           " was surveyed; set where one lies in the grid first, or ask for "
                                           "frame=component");
}

Pose in_component(const AtlasView& view, const Placement& placement, const Keyframe& keyframe) {
  const auto found = view.corrections.find(placement.session);
  return found == view.corrections.end() ? placement.T_component_session * keyframe.T_local_sensor
                                         : found->second->corrected(keyframe.sequence, keyframe.T_local_sensor);
}

Result<PlacedComponent> placed_component(const Station& station, SessionId id, OutputFrame frame) {
  const AtlasView view = station.atlas();
  const auto component = find_component(view.atlas, id);
  if (!component) return tl::unexpected(component.error());
  const auto T_frame_component = frame_of(station, *component, frame);
  if (!T_frame_component) return tl::unexpected(T_frame_component.error());
  std::map<SessionId, SessionRow> rows;
  for (SessionRow& row : station.sessions()) rows[row.id] = std::move(row);
  PlacedComponent placed;
  for (const Placement& placement : component->placements) {
    const auto keyframes = station.trajectory(placement.session);
    if (!keyframes) return tl::unexpected(keyframes.error());
    for (const Keyframe& keyframe : *keyframes)
      placed.keyframes.push_back({placed.sessions.size(), keyframe.sequence,
                                  *T_frame_component * in_component(view, placement, keyframe), keyframe.stamp_s});
    placed.sessions.push_back(rows[placement.session]);
  }
  if (frame == OutputFrame::grid)
    placed.origin_m = T_frame_component->translation().array().round();
  else if (!placed.keyframes.empty())
    placed.origin_m = origin_near(placed.keyframes.front().T_frame_sensor.translation());
  return placed;
}

}  // namespace headframe
