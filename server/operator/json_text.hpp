#pragma once
// How the operator's API writes JSON: one line, names in the order that they were given.

#include <nlohmann/json.hpp>
#include <string>

namespace headframe {

using Json = nlohmann::ordered_json;

/// Never throws: names are peers' bytes, and what is no UTF-8 is replaced.
inline std::string text(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n"; }

}  // namespace headframe
