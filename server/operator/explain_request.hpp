#pragma once

#include <string>

#include "server/station/station.hpp"

namespace headframe {

/// The session with this name: "robot/session", or "robot" if the robot has just one. not_found: there is none, or
/// several; the message lists the sessions.
Result<SessionRow> find_session(const std::vector<SessionRow>& sessions, const std::string& name);

/// Why the two sessions are merged or not (server/atlas/explain.hpp), as JSON. not_found: a name fits no session, or
/// several; invalid_argument: both names mean the same session.
Result<std::string> explain_request(const Station& station, const std::string& a, const std::string& b);

/// The same for a given placement of the two sessions that was judged.
std::string explain_placement(const Station& station, const SessionRow& a, const SessionRow& b,
                              const Alignment& placement);

}  // namespace headframe
