#pragma once
// A component in the frame in which it is to be output.

#include "server/station/station.hpp"

namespace headframe {

/// The component's own frame, or the mine's grid according to the survey of one of its sessions.
enum class OutputFrame { component, grid };

Result<OutputFrame> output_frame_from(const std::string& name);

struct PlacedKeyframe {
  std::size_t session = 0;  // index in PlacedComponent::sessions
  std::uint64_t sequence = 0;
  Pose T_frame_sensor = Pose::Identity();
  double stamp_s = 0;  // from the robot's clock
};

struct PlacedComponent {
  std::vector<SessionRow> sessions;
  std::vector<PlacedKeyframe> keyframes;  // session by session, in order of sequence
  /// A point near the component, in whole metres, as the origin for formats with single precision. In the component's
  /// frame it is zero unless the component is 10 km or more away.
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
};

/// Reads the keyframes from the disk. not_found: no such component, or no survey of it.
Result<PlacedComponent> placed_component(const Station& station, SessionId component, OutputFrame frame);

/// T_component_sensor of a keyframe, as corrected by the pose graph.
Pose in_component(const AtlasView& view, const Placement& placement, const Keyframe& keyframe);

/// T_frame_component. For the grid, the survey that was set last counts. not_found: none of its sessions has a survey.
Result<Pose> frame_of(const Station& station, const Component& component, OutputFrame frame);

/// The component with this id. not_found: the message lists the ids that exist.
Result<Component> find_component(const Atlas& atlas, SessionId id);

}  // namespace headframe
