#pragma once

#include <string>
#include <string_view>

namespace headframe {

/// What a peer wrote, for a log, a terminal or a page: UTF-8 in which each character that does not stand for itself is
/// a '?': control characters (C0, C1, delete), line and paragraph separators, marks that turn the direction of writing,
/// invisible ones, and bytes that are no UTF-8.
std::string printable(std::string_view text);

}  // namespace headframe
