#pragma once
// One question to the server's HTTP API.

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/base_station.hpp"

namespace headframe::demo {

/// GET http://ADDRESS/TARGET as JSON. Fails (unavailable) when there is no answer in time, (bad_input) on another
/// status than 200 or an answer that is no JSON.
Result<nlohmann::json> http_get(const test::BaseStation& station, const std::string& target,
                                std::chrono::seconds timeout);

}  // namespace headframe::demo
