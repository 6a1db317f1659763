#pragma once
// The present poses of keyframes. pose_updates holds what robots reported and merging has not used yet, moved_poses
// what it uses; the keyframe's own row keeps the original pose.

#include "server/store/database.hpp"
#include "server/store/store.hpp"

namespace headframe {

/// Repeated and older updates have no effect. invalid_argument: a keyframe that is not stored.
Result<void> put(Database& database, const PutPoses& write);
/// From now on merging uses these poses, and the session is tried again; without poses nothing had really moved.
/// Updates up to that number no longer wait.
Result<void> put(Database& database, const MovedPoses& write);
/// Moves the keyframes from write.from on, with their poses, to the new part of the session.
Result<void> carry_over_poses(Database& database, const SplitSession& write);
Result<NewPoses> read_new_poses(Database& database, SessionId session);

/// The checksum of a row in either table.
std::int64_t pose_checksum(std::int64_t session, std::uint64_t sequence, std::string_view pose_blob);

}  // namespace headframe
