#pragma once

#include <spdlog/formatter.h>

#include <memory>

namespace headframe {

/// Makes every log entry a single line: its text goes through printable() before any sink gets it, so that no peer can
/// forge a line or move a terminal's cursor.
std::unique_ptr<spdlog::formatter> printable_log();

}  // namespace headframe
