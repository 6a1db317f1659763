#pragma once

#include "server/net/robot_protocol.hpp"

namespace headframe {

/// The protocol's next event; a cloud that arrived is checked here, as the connection has it done elsewhere.
inline std::optional<RobotEvent> next_event(RobotProtocol& protocol) {
  auto event = protocol.next();
  auto* arrived = event ? std::get_if<CloudArrived>(&*event) : nullptr;
  if (!arrived) return event;
  const auto decodes = RobotProtocol::check(*arrived);
  return protocol.checked(std::move(*arrived), decodes);
}

}  // namespace headframe
