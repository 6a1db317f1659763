#include "server/store/pose_rows.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "server/store/columns.hpp"
#include "server/store/keyframe_row.hpp"
#include "server/store/row_checksum.hpp"

namespace headframe {
namespace {

Result<void> put_waiting(Database& db, SessionId session, std::uint64_t number, std::uint64_t keyframes,
                         const KeyframePose& pose) {
  const std::string T = pose_blob(pose.T_local_sensor);
  return db.run(
      "INSERT INTO pose_updates (session, sequence, number, keyframes, T_local_sensor, checksum) VALUES (?,?,?,?,?,?)"
      " ON CONFLICT (session, sequence) DO UPDATE SET number=excluded.number, keyframes=CASE WHEN excluded.keyframes <"
      " pose_updates.keyframes THEN excluded.keyframes ELSE pose_updates.keyframes END,"
      " T_local_sensor=excluded.T_local_sensor, checksum=excluded.checksum",
      session, pose.sequence, number, keyframes, Blob{T}, pose_checksum(session, pose.sequence, T));
}

Result<void> put_moved(Database& db, SessionId session, const KeyframePose& pose) {
  const std::string T = pose_blob(pose.T_local_sensor);
  return db.run(
      "INSERT INTO moved_poses (session, sequence, T_local_sensor, checksum) VALUES (?,?,?,?) ON CONFLICT (session,"
      " sequence) DO UPDATE SET T_local_sensor=excluded.T_local_sensor, checksum=excluded.checksum",
      session, pose.sequence, Blob{T}, pose_checksum(session, pose.sequence, T));
}

/// Skips damaged rows; their keyframes stay where they were.
template <class Visit>
Result<void> each_pose(Database& db, const std::string& columns, SessionId session, std::uint64_t first, Visit visit) {
  return db.each(
      "SELECT sequence, T_local_sensor, checksum, " + columns + " WHERE session=? AND sequence>=? ORDER BY sequence",
      [&](const Row& row) {
        const auto sequence = static_cast<std::uint64_t>(row.integer(0));
        if (row.integer(2) == pose_checksum(session, sequence, row.blob(1)))
          visit(row, KeyframePose{sequence, pose_from_blob(row.blob(1))});
      },
      session, first);
}

}  // namespace

std::int64_t pose_checksum(std::int64_t session, std::uint64_t sequence, std::string_view pose_blob) {
  return RowChecksum().add(static_cast<std::uint64_t>(session)).add(sequence).add(pose_blob).value();
}

Result<void> put(Database& db, const PutPoses& write) {
  std::optional<std::uint64_t> newest;
  auto done = db.each(
      "SELECT pose_update FROM sessions WHERE id=?",
      [&](const Row& row) { newest = static_cast<std::uint64_t>(row.integer(0)); }, write.session);
  if (!done) return done;
  if (!newest)
    return failure(ErrorCode::invalid_argument,
                   "poses of session " + std::to_string(write.session) + ", which is not stored");
  if (*newest >= write.number) return done;
  for (const auto& [session, of] : write.sessions) {
    const auto last = last_keyframe(db, session);
    if (!last) return tl::unexpected(last.error());
    if (of.poses.empty() || of.poses.back().sequence > *last)
      return failure(ErrorCode::invalid_argument, "poses of keyframes of session " + std::to_string(session) +
                                                      " after " + std::to_string(*last) + ", the last that is stored");
    for (const KeyframePose& pose : of.poses)
      if (done) done = put_waiting(db, session, write.number, of.keyframes, pose);
  }
  return done ? db.run("UPDATE sessions SET pose_update=? WHERE id=?", write.number, write.session) : done;
}

Result<void> put(Database& db, const MovedPoses& write) {
  Result<void> done;
  for (const KeyframePose& pose : write.poses)
    if (done) done = put_moved(db, write.session, pose);
  if (done) done = db.run("DELETE FROM pose_updates WHERE session=? AND number<=?", write.session, write.number);
  if (write.poses.empty()) return done;
  // Attempts with the earlier poses have to be repeated, also after a restart.
  return done ? db.run("UPDATE sessions SET attempted_keyframes=0, attempted_whole=0 WHERE id=?", write.session) : done;
}

Result<void> carry_over_poses(Database& db, const SplitSession& write) {
  const SessionId part = write.part.id;
  const std::uint64_t before = write.from - 1;
  std::vector<KeyframePose> moved;
  std::vector<std::pair<KeyframePose, std::pair<std::uint64_t, std::uint64_t>>> waiting;
  auto done = each_pose(db, "session FROM moved_poses", write.session, write.from,
                        [&](const Row&, const KeyframePose& pose) { moved.push_back(pose); });
  if (done)
    done = each_pose(db, "number, keyframes FROM pose_updates", write.session, write.from,
                     [&](const Row& row, const KeyframePose& pose) {
                       const auto of = [&](int column) { return static_cast<std::uint64_t>(row.integer(column)); };
                       waiting.push_back({pose, {of(3), of(4)}});
                     });
  for (const KeyframePose& pose : moved)
    if (done) done = put_moved(db, part, {pose.sequence - before, pose.T_local_sensor});
  for (const auto& [pose, of] : waiting)
    if (done) done = put_waiting(db, part, of.first, of.second - before, {pose.sequence - before, pose.T_local_sensor});
  for (const char* table : {"moved_poses", "pose_updates"})
    if (done)
      done =
          db.run(std::string("DELETE FROM ") + table + " WHERE session=? AND sequence>=?", write.session, write.from);
  return done;
}

Result<NewPoses> read_new_poses(Database& db, SessionId session) {
  NewPoses out;
  const auto read =
      each_pose(db, "number, keyframes FROM pose_updates", session, 1, [&](const Row& row, const KeyframePose& pose) {
        const auto keyframes = static_cast<std::uint64_t>(row.integer(4));
        out.keyframes = out.poses.empty() ? keyframes : std::min(out.keyframes, keyframes);
        out.number = std::max(out.number, static_cast<std::uint64_t>(row.integer(3)));
        out.poses.push_back(pose);
      });
  if (!read) return tl::unexpected(read.error());
  return out;
}

}  // namespace headframe
