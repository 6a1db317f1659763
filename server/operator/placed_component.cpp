#include "server/operator/placed_component.hpp"

#include <map>
#include <sstream>

namespace headframe {
namespace {

/// A robot may count its metres from far away (UTM), and what it anchors lies there.
Eigen::Vector3d origin_near(const Eigen::Vector3d& p_m) {
  constexpr double near_m = 10e3;  // single precision holds a millimetre there
  if (p_m.cwiseAbs().maxCoeff() < near_m) return Eigen::Vector3d::Zero();
  return p_m.array().round();
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
  if (const auto T_grid_component = grid_of(component, station.surveys())) return *T_grid_component;
  return failure(ErrorCode::not_found, "no session of component " + std::to_string(component.id) +
                                           " was surveyed; set where one lies in the grid first, or ask for "
                                           "frame=component");
}

Result<PlacedComponent> placed_component(const Station& station, SessionId id, OutputFrame frame) {
  const auto component = find_component(station.atlas().atlas, id);
  if (!component) return tl::unexpected(component.error());
  const auto T_frame_component = frame_of(station, *component, frame);
  if (!T_frame_component) return tl::unexpected(T_frame_component.error());
  std::map<SessionId, SessionRow> rows;
  for (SessionRow& row : station.sessions()) rows[row.id] = std::move(row);
  PlacedComponent placed;
  for (const Placement& placement : component->placements) {
    const auto keyframes = station.trajectory(placement.session);
    if (!keyframes) return tl::unexpected(keyframes.error());
    const Pose T_frame_session = *T_frame_component * placement.T_component_session;
    for (const Keyframe& keyframe : *keyframes)
      placed.keyframes.push_back(
          {placed.sessions.size(), keyframe.sequence, T_frame_session * keyframe.T_local_sensor, keyframe.stamp_s});
    placed.sessions.push_back(rows[placement.session]);
  }
  if (frame == OutputFrame::grid)
    placed.origin_m = T_frame_component->translation().array().round();
  else if (!placed.keyframes.empty())
    placed.origin_m = origin_near(placed.keyframes.front().T_frame_sensor.translation());
  return placed;
}

}  // namespace headframe
