#pragma once
// A component laid out in the frame that somebody wants it in.

#include "server/station/station.hpp"

namespace headframe {

/// The component's own frame, or the mine's grid by the survey of one of its sessions.
enum class OutputFrame { component, grid };

Result<OutputFrame> output_frame_from(const std::string& name);

struct PlacedKeyframe {
  std::size_t session = 0;  // in PlacedComponent::sessions
  std::uint64_t sequence = 0;
  Pose T_frame_sensor = Pose::Identity();
  double stamp_s = 0;  // by the robot's clock
};

struct PlacedComponent {
  std::vector<SessionRow> sessions;
  std::vector<PlacedKeyframe> keyframes;  // session by session, in the order of their sequence
  /// Near the component, in whole metres: what formats of single precision count from. Zero in the component's frame
  /// where that is near enough.
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
};

/// Reads the keyframes from disk. not_found: no such component, or no survey of it.
Result<PlacedComponent> placed_component(const Station& station, SessionId component, OutputFrame frame);

/// T_component_sensor of a keyframe, where the pose graph puts it.
Pose in_component(const AtlasView& view, const Placement& placement, const Keyframe& keyframe);

/// T_frame_component; not_found: none of its sessions was surveyed.
Result<Pose> frame_of(const Station& station, const Component& component, OutputFrame frame);

/// "No component 7; there are 1, 4.", for every place that needs a component.
Result<Component> find_component(const Atlas& atlas, SessionId id);

}  // namespace headframe
