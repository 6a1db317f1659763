#pragma once
// The log entries for the difference between two snapshots of the station, and one for each action of an operator. All
// functions are pure.

#include <map>
#include <optional>
#include <string_view>

#include "server/operator/event_diff.hpp"
#include "server/operator/event_log.hpp"

namespace headframe {

/// Entries for robots that connect and leave, sessions that end or are cut, clouds that were deleted to make room,
/// results for pairs, and new revisions. A published merge that is no longer published, without an operator's decision,
/// is "withdrawn". What an operator decided is left out here, because operator_line() logs it; so are pairs that are
/// not merged only because a session is archived or of another site.
std::vector<LogEntry> log_lines(const StationLook& before, const StationLook& after);

/// The entry for a request that changes something: "An operator took a/1 and b/1 apart.", with the name `who` if it is
/// not empty. nullopt: the request changes nothing, or its route logs it itself.
/// `parameters` are those of the query and of the path, by name. Names of sessions are looked up at once, so call this
/// before the session is deleted.
std::optional<LogEntry> operator_line(std::string_view method, std::string_view path,
                                      const std::map<std::string, std::string>& parameters, const Station& station,
                                      const std::string& who = {});

}  // namespace headframe
