#pragma once

#include <string>
#include <string_view>

namespace headframe {

/// Makes a peer's text safe for a log, a terminal or a page: valid UTF-8 in which these are replaced by '?': control
/// characters (C0, C1, delete), line and paragraph separators, marks that change the direction of writing, invisible
/// characters, and bytes that are not UTF-8.
std::string printable(std::string_view text);

}  // namespace headframe
