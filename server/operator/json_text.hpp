#pragma once
// How the operator's API writes JSON: on one line, with names in the order in which they were added.

#include <nlohmann/json.hpp>
#include <string>

namespace headframe {

using Json = nlohmann::ordered_json;

/// Never throws: names come from peers, and invalid UTF-8 in them is replaced.
inline std::string text(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n"; }

}  // namespace headframe
