#include "server/relay_target.hpp"

#include <algorithm>

namespace headframe {

Result<Endpoint> relay_target(const std::vector<ServerRecord>& servers, Door door, const Endpoint& own) {
  const auto active = std::find_if(servers.begin(), servers.end(), [](const auto& server) { return server.is_active; });
  if (active == servers.end() || active->is_self || !active->relayed)
    return failure(ErrorCode::unavailable, "no server is active that takes connections from this one");
  const bool robots = door == Door::robots;
  const std::string& at = robots ? active->robots : active->http;
  const std::string whom = robots ? "robots" : "operators", option = robots ? "--listen" : "--http";
  const auto refused = [&](const std::string& why) {
    return failure(ErrorCode::refused, "the active server, " + active->name + ", takes " + whom + " on " + at + ", " +
                                           why + "; this one has " + to_string(own) + " for them");
  };
  const auto target = parse_peer(at);
  if (!target) return refused("which is no address");
  if (is_any_address(*target))
    return refused("and does not say by which of its addresses it is reached: set public in [server] there");
  if (target->host == own.host && target->port == own.port)
    return refused("where this one is, too: give it another " + option + ", which other machines reach");
  if (is_loopback(*target) && (!is_loopback(own) || !active->shares_loopback))
    return refused("which is reached from its machine alone: give it another " + option);
  return *target;
}

}  // namespace headframe
