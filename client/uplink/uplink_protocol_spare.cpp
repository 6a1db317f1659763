// A spare connection beside the one that carries the session, until it takes over.
#include "client/uplink/uplink_protocol.hpp"

namespace headframe {

void UplinkProtocol::stand_by() {
  carries_ = carried_alone_ = false;
  probed_ = Probed::no;
  requested_.clear();
  clouds_in_flight_.clear();
  requested_transfer_.reset();
  background_transfer_.reset();
  pose_transfer_.reset();
}

/// Both messages are sent together, so that one packet that gets through brings both.
void UplinkProtocol::probe(std::uint64_t durable) {
  sent_keyframes_ = durable_keyframes_ = durable;
  probed_ = Probed::asked;
  std::string keyframe;  // empty if it cannot be read; then the connection that carries the session ends
  if (durable < source_.last_sequence() && policy_.hold.empty())
    if (const auto next = next_keyframe()) (void)append_frame(keyframe, next->SerializeAsString());
  v1::RobotMessage probe;
  probe.mutable_probe()->set_keyframe_follows(!keyframe.empty());
  std::string frames;
  (void)append_frame(frames, probe.SerializeAsString());
  if (queue_frames(frames + keyframe) && !keyframe.empty()) ++sent_keyframes_;
}

std::vector<UplinkEvent> UplinkProtocol::take_over() {
  carries_ = true;
  probed_ = Probed::no;
  sent_update_ = durable_update_;
  background_from_ = 1;  // what the other connection sent may not have arrived
  v1::RobotMessage message;
  (void)message.mutable_take_over();
  queue(message);
  return {policy_};
}

}  // namespace headframe
