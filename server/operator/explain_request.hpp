#pragma once

#include <string>

#include "server/station/station.hpp"

namespace headframe {

/// The one session that is named "robot/session", or "robot" when it has just one. not_found: with those there are.
Result<SessionRow> find_session(const std::vector<SessionRow>& sessions, const std::string& name);

/// Why the two sessions are or are not merged (server/atlas/explain.hpp), as JSON. not_found and invalid_argument: the
/// names do not name two sessions.
Result<std::string> explain_request(const Station& station, const std::string& a, const std::string& b);

/// The same of a placement of the two, as it was judged.
std::string explain_placement(const Station& station, const SessionRow& a, const SessionRow& b,
                              const Alignment& placement);

}  // namespace headframe
