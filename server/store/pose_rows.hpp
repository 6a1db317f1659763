#pragma once
// Where keyframes lie now. pose_updates holds what robots said and merging has not taken in yet, moved_poses what it
// has; the keyframe's own row keeps the pose that it came with.

#include "server/store/database.hpp"
#include "server/store/store.hpp"

namespace headframe {

/// Repeats and older updates change nothing. invalid_argument: of a keyframe that is not stored.
Result<void> put(Database& database, const PutPoses& write);
/// From now on the keyframes lie there, and the session is tried again; without any it only turned out that nothing had
/// moved. Updates up to that number wait no more.
Result<void> put(Database& database, const MovedPoses& write);
/// The keyframes from write.from on are the part's, and so are their poses.
Result<void> carry_over_poses(Database& database, const SplitSession& write);
Result<NewPoses> read_new_poses(Database& database, SessionId session);

/// The checksum of a row of either table.
std::int64_t pose_checksum(std::int64_t session, std::uint64_t sequence, std::string_view pose_blob);

}  // namespace headframe
