#pragma once

#include "server/merge/alignment_book.hpp"
#include "server/merge/localization.hpp"

namespace headframe {

/// Where the session lies in a map: as it is merged; else by the alignment that convinces most, when it has shown the
/// path that SessionMap::path_awaited_to_localize_m asks for, nothing else it found casts doubt on it, and no session
/// of that map contradicts it there (`contacts`). In the robots' frames; not found while there is nothing of this.
/// Pure.
SessionLocalization localize(SessionId id, const SessionMap& sessions, const AlignmentBook& book,
                             const Contacts& contacts);

}  // namespace headframe
