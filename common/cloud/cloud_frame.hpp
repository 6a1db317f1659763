#pragma once
// The zstd frame around a cloud's content.

#include <string>
#include <string_view>

#include "common/result.hpp"

namespace headframe::cloud_form {

Result<std::string> compress(const std::string& content);

/// Accepts any bytes: takes no more memory than the content of the largest cloud needs, whatever they claim.
Result<std::string> decompress(std::string_view bytes);

}  // namespace headframe::cloud_form
