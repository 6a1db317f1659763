#pragma once

#include "server/merge/alignment_book.hpp"
#include "server/merge/localization.hpp"

namespace headframe {

/// Where the session lies in a map. If it is merged, its place there; otherwise the most convincing alignment, provided
/// that the session has driven the path that SessionMap::path_awaited_to_localize_m demands, no other placement casts
/// doubt on it, and no session of that map contradicts it (`contacts`). In the robots' frames. Pure.
SessionLocalization localize(SessionId id, const SessionMap& sessions, const AlignmentBook& book,
                             const Contacts& contacts);

}  // namespace headframe
