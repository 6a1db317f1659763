// The robot's questions about the map that others made.
#include "client/uplink/localization_message.hpp"
#include "client/uplink/uplink_protocol.hpp"

namespace headframe {

void UplinkProtocol::on_localization(const v1::Localization& message, Events& events) {
  auto told = localization_from(message);
  if (!told) return end(events, ErrorCode::bad_input, "localization: " + told.error().message, false);
  events.emplace_back(std::move(*told));
}

bool UplinkProtocol::localize(bool asks) {
  if (!localizes_) return false;
  v1::RobotMessage message;
  message.mutable_localize()->set_stop(!asks);
  queue(message);
  return true;
}

bool UplinkProtocol::ask_around(const v1::RobotMessage& question) {
  if (knows_around_) queue(question);
  return knows_around_;
}

}  // namespace headframe
