#pragma once

#include <spdlog/formatter.h>

#include <memory>

namespace headframe {

/// One line an entry, whatever was written by whom: what an entry says goes through printable() before any sink gets
/// it, so that no peer can forge a line or move a terminal's cursor.
std::unique_ptr<spdlog::formatter> printable_log();

}  // namespace headframe
