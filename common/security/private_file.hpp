#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace headframe {

/// A small file that nobody but its owner may read. not_found: there is none; refused: others can read it; unavailable:
/// the disk says no; bad_input: longer than 64 KiB.
Result<std::string> read_private_file(const std::filesystem::path& path);

/// Replaces it as a whole (mode 0600): after a crash it is the old one or the new one, and on the disk when this
/// returns.
Result<void> write_private_file(const std::filesystem::path& path, std::string_view content);

}  // namespace headframe
