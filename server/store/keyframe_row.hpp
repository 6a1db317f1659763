#pragma once
// A keyframe as a row of a table.

#include <optional>

#include "common/session/keyframe.hpp"
#include "server/store/database.hpp"

namespace headframe {

/// SELECT ... FROM keyframes, with the columns that keyframe_of() reads; the caller appends conditions.
std::string select_keyframes();
/// Nullopt if the row is not what was written. Rows from before there were checksums are trusted.
std::optional<Keyframe> keyframe_of(const Row& row);

/// The same with the poses that merging uses now; the table keyframes has the alias k.
std::string select_moved_keyframes();
std::optional<Keyframe> moved_keyframe_of(const Row& row);

/// Replaces a keyframe whose row is damaged: it keeps its number, gets its neighbour's pose, and has no walls,
/// descriptor or cloud.
Keyframe stand_in(std::uint64_t sequence, const Keyframe& neighbour);

/// Inserts the keyframe if it follows the last one of a stored session; `stored` is then called with 1, else with 0.
Result<void> insert_keyframe(Database& database, std::int64_t session, const Keyframe& keyframe,
                             const Database::Changed& stored);

/// The last sequence number of a session; 0: none.
Result<std::uint64_t> last_keyframe(Database& database, std::int64_t session);

/// The difference between two keyframes, in words; nullptr if they are the same, allowing for rounding by another build
/// of the server.
const char* difference(const Keyframe& stored, const Keyframe& repeated);

}  // namespace headframe
