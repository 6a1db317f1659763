#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace headframe {

/// Reads a small file that only its owner may read. not_found: there is none; refused: others can read it; unavailable:
/// the disk failed; bad_input: longer than 64 KiB.
Result<std::string> read_private_file(const std::filesystem::path& path);

/// Replaces the file atomically (mode 0600). On return it is on the disk; after a crash it is either the old or the new
/// one.
Result<void> write_private_file(const std::filesystem::path& path, std::string_view content);

}  // namespace headframe
