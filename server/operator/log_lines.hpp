#pragma once
// What of the difference of two looks at the station is worth a line in the log, and a line for each thing an operator
// does. Pure.

#include <map>
#include <optional>
#include <string_view>

#include "server/operator/event_diff.hpp"
#include "server/operator/event_log.hpp"

namespace headframe {

/// Robots that come and go, sessions that end, and what becomes of pairs. A merge that stood and stands no more,
/// without an operator having decided so, is "withdrawn". What an operator decided has its own line and is left out
/// here.
std::vector<LogEntry> log_lines(const StationLook& before, const StationLook& after);

/// "An operator took a/1 and b/1 apart.", or with the name of `who` did it, of a request that changes something; none:
/// the request only asks, or its route writes a line of its own.
/// `parameters` are those of the query and of the path, by their names. Names are looked up now: ask before what is
/// named is deleted.
std::optional<LogEntry> operator_line(std::string_view method, std::string_view path,
                                      const std::map<std::string, std::string>& parameters, const Station& station,
                                      const std::string& who = {});

}  // namespace headframe
