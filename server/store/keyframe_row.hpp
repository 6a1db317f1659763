#pragma once
// A keyframe as a row of its table.

#include <optional>

#include "common/session/keyframe.hpp"
#include "server/store/database.hpp"

namespace headframe {

/// SELECT ... FROM keyframes, with the columns that keyframe_of() reads; conditions follow.
std::string select_keyframes();
/// nullopt: what is in the row is not what was written there. Rows of before there were checksums are believed.
std::optional<Keyframe> keyframe_of(const Row& row);

/// The same where merging has it by now: keyframes are called k there.
std::string select_moved_keyframes();
std::optional<Keyframe> moved_keyframe_of(const Row& row);

/// What stands for a keyframe whose row is damaged: its number, at the place of its neighbour, and nothing seen there.
Keyframe stand_in(std::uint64_t sequence, const Keyframe& neighbour);

/// Makes its row if it follows the last of a session that is stored; `stored` is told 1 then, else 0.
Result<void> insert_keyframe(Database& database, std::int64_t session, const Keyframe& keyframe,
                             const Database::Changed& stored);

/// The last sequence of a session; 0: it has none.
Result<std::uint64_t> last_keyframe(Database& database, std::int64_t session);

/// What tells two keyframes apart, for people; nullptr: they are the same one, if perhaps computed from its bytes by
/// another build of the server.
const char* difference(const Keyframe& stored, const Keyframe& repeated);

}  // namespace headframe
