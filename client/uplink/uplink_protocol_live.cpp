// The robot's condition: sent when it changes, and from time to time if it does not.
#include "client/uplink/uplink_protocol.hpp"

namespace headframe {
namespace {

constexpr auto changed_every = std::chrono::seconds(1), same_every = std::chrono::seconds(5);

bool moved(const Pose& T, const Pose& T_said) {
  constexpr double least_m = 0.05, least_rad = 0.02;
  return (T.translation() - T_said.translation()).norm() > least_m ||
         rotation_angle_rad(T.inverse() * T_said) > least_rad;
}

bool changed(const LiveState& now, const LiveState& said) {
  if (now.health != said.health || now.battery != said.battery) return true;
  if (!now.T_local_sensor || !said.T_local_sensor)
    return now.T_local_sensor.has_value() != said.T_local_sensor.has_value();
  return moved(*now.T_local_sensor, *said.T_local_sensor);
}

}  // namespace

void UplinkProtocol::queue_live(Time now) {
  if (!takes_live_ || (live_said_at_ && now - *live_said_at_ < changed_every)) return;
  const auto state = source_.live();
  if (!state) return;
  if (live_said_at_ && now - *live_said_at_ < same_every && !changed(*state, live_said_)) return;
  live_said_at_ = now;
  live_said_ = *state;
  v1::RobotMessage message;
  *message.mutable_live() = to_proto(*state);
  message.set_backlog(source_.last_sequence() - sent_keyframes_);
  queue(message);
}

}  // namespace headframe
