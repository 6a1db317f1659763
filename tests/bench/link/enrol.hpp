#pragma once

#include <filesystem>
#include <string>

#include "common/result.hpp"

namespace headframe::bench {

/// What `headframe robot add` would print for this robot, from the server whose operator API is at http (HOST:PORT) and
/// whose data directory is `data`.
Result<std::string> enrolment(const std::string& http, const std::filesystem::path& data, const std::string& robot);

}  // namespace headframe::bench
