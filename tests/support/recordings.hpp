#pragma once

#include <cstdlib>
#include <filesystem>

namespace headframe::test {

/// HEADFRAME_RECORDINGS, or the folder that lies beside the checkout. Tests that need them are skipped where they are
/// absent.
inline std::filesystem::path recordings() {
  if (const char* named = std::getenv("HEADFRAME_RECORDINGS")) return named;
  return std::filesystem::path(HEADFRAME_SOURCE_DIR).parent_path() / "shared" / "data";
}

}  // namespace headframe::test
