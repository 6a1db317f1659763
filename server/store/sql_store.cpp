#include "server/store/sql_store.hpp"

#include <utility>

#include "server/store/keyframe_row.hpp"
#include "server/store/pose_rows.hpp"
#include "server/store/session_reads.hpp"
#include "server/store/stored_merge.hpp"

namespace headframe {
namespace {

SessionRecord session_of(const Row& row) {
  SessionRecord s;
  s.id = row.integer(0);
  s.key = {row.text(1), row.text(2)};
  s.sensor = {row.text(3), static_cast<int>(row.integer(4)), static_cast<float>(row.real(5)),
              static_cast<float>(row.real(6)), static_cast<float>(row.real(7))};
  s.family = {row.text(8), static_cast<int>(row.integer(9))};
  s.q_size = static_cast<std::uint32_t>(row.integer(10));
  s.w_size = static_cast<std::uint32_t>(row.integer(11));
  s.spool_id = static_cast<std::uint64_t>(row.integer(12));
  s.complete = row.integer(13) != 0;
  s.attempted_keyframes = static_cast<std::uint64_t>(row.integer(14));
  s.spool_run = static_cast<std::uint64_t>(row.integer(15));
  s.attempted_whole = row.integer(16) != 0;
  s.archived = row.integer(17) != 0;
  s.site = row.text(18);
  s.pose_update = static_cast<std::uint64_t>(row.integer(19));
  return s;
}

}  // namespace

SqlStore::SqlStore(SqlStoreParts parts)
    : directory_(std::move(parts.directory)),
      write_backup_(std::move(parts.write_backup)),
      free_bytes_(std::move(parts.free_bytes)),
      reader_(std::move(parts.reader)),
      writer_(std::move(parts.writer), parts.options) {}

StoreLoad SqlStore::load() const {
  StoreLoad load = writer_.load();
  load.damaged_keyframes = damaged_count_;
  return load;
}

bool SqlStore::is_away() {
  const std::lock_guard lock(mutex_);
  return !reader_->is_connected();
}

Result<std::vector<SessionRecord>> SqlStore::sessions() {
  std::vector<SessionRecord> sessions;
  const std::lock_guard lock(mutex_);
  auto read = reader_->each(
      "SELECT id, robot, session, sensor_model, beams, fov_up_deg, fov_down_deg, max_range_m, family,"
      " family_version, q_size, w_size, spool_id, complete, attempted_keyframes, spool_run, attempted_whole, archived,"
      " site, pose_update FROM sessions ORDER BY id",
      [&](const Row& row) { sessions.push_back(session_of(row)); });
  if (!read) return tl::unexpected(read.error());
  return sessions;
}

Result<void> SqlStore::each_keyframe(SessionId session, std::uint64_t first,
                                     const std::function<void(Keyframe)>& visit) {
  const std::lock_guard lock(mutex_);
  return read_keyframes(*reader_, session, first, visit, [&](std::uint64_t sequence) {
    note_damage({session, sequence});
  });
}

Result<NewPoses> SqlStore::new_poses(SessionId session) {
  const std::lock_guard lock(mutex_);
  return read_new_poses(*reader_, session);
}

Result<std::uint64_t> SqlStore::last_keyframe(SessionId session) {
  const std::lock_guard lock(mutex_);
  return headframe::last_keyframe(*reader_, session);
}

Result<std::vector<std::uint64_t>> SqlStore::cloud_sequences(SessionId session) {
  const std::lock_guard lock(mutex_);
  return read_cloud_sequences(*reader_, session);
}

Result<std::vector<CloudSize>> SqlStore::cloud_sizes(SessionId session) {
  std::vector<CloudSize> sizes;
  const std::lock_guard lock(mutex_);
  auto read = reader_->each(
      "SELECT sequence, length(encoded) FROM clouds WHERE session=? ORDER BY sequence",
      [&](const Row& row) {
        sizes.push_back({static_cast<std::uint64_t>(row.integer(0)), static_cast<std::uint64_t>(row.integer(1))});
      },
      session);
  if (!read) return tl::unexpected(read.error());
  return sizes;
}

Result<std::vector<std::uint64_t>> SqlStore::let_go(SessionId session) {
  std::vector<std::uint64_t> sequences;
  const std::lock_guard lock(mutex_);
  auto read = reader_->each(
      "SELECT sequence FROM let_go WHERE session=? ORDER BY sequence",
      [&](const Row& row) { sequences.push_back(static_cast<std::uint64_t>(row.integer(0))); }, session);
  if (!read) return tl::unexpected(read.error());
  return sequences;
}

Result<std::optional<std::uint64_t>> SqlStore::free_bytes() {
  const std::lock_guard lock(mutex_);
  return free_bytes_(*reader_);
}

Result<std::string> SqlStore::cloud(const KeyframeRef& keyframe) {
  const std::lock_guard lock(mutex_);
  if (damaged_.contains(keyframe))
    return failure(ErrorCode::not_found, "the row of keyframe " + std::to_string(keyframe.sequence) + " of session " +
                                             std::to_string(keyframe.session) +
                                             " is damaged: where its cloud belongs is not known");
  return read_cloud(*reader_, keyframe);
}

Result<std::vector<RobotRecord>> SqlStore::robots() {
  std::vector<RobotRecord> robots;
  const std::lock_guard lock(mutex_);
  auto read = reader_->each(
      "SELECT name, token_digest, code_digest, code_expires_s, enrolled_s, revoked, rate_kib_s FROM robots"
      " ORDER BY name",
      [&](const Row& row) {
        robots.push_back({row.text(0), row.text(1), row.text(2), row.real(3), row.real(4), row.integer(5) != 0,
                          static_cast<std::uint64_t>(row.integer(6))});
      });
  if (!read) return tl::unexpected(read.error());
  return robots;
}

Result<std::map<std::string, std::string>> SqlStore::robot_sites() {
  std::map<std::string, std::string> sites;
  const std::lock_guard lock(mutex_);
  auto read =
      reader_->each("SELECT robot, site FROM robot_sites", [&](const Row& row) { sites[row.text(0)] = row.text(1); });
  if (!read) return tl::unexpected(read.error());
  return sites;
}

Result<std::vector<TroubleRecord>> SqlStore::troubles() {
  std::vector<TroubleRecord> troubles;
  const std::lock_guard lock(mutex_);
  auto read = reader_->each("SELECT session, deaths, kills, why_aside, deleted FROM troubles ORDER BY session",
                            [&](const Row& row) {
                              troubles.push_back({row.integer(0), static_cast<int>(row.integer(1)),
                                                  static_cast<int>(row.integer(2)), row.text(3), row.integer(4) != 0});
                            });
  if (!read) return tl::unexpected(read.error());
  return troubles;
}

Result<StoredMerge> SqlStore::merge() {
  const std::lock_guard lock(mutex_);
  return read_merge(*reader_);
}

Result<StoredNotes> SqlStore::notes() {
  const std::lock_guard lock(mutex_);
  return read_notes(*reader_);
}

Result<std::filesystem::path> SqlStore::backup() {
  const std::unique_lock one(backup_mutex_, std::try_to_lock);
  if (!one) return failure(ErrorCode::unavailable, "another backup is being made; try again when it is there");
  auto file = directory_.path() / ("headframe.backup-" + std::to_string(++backups_));
  if (auto made = write_backup_(file); !made) return tl::unexpected(made.error());
  return file;
}

/// Call under the lock.
void SqlStore::note_damage(const KeyframeRef& keyframe) {
  damaged_.insert(keyframe);
  damaged_count_ = damaged_.size();
}

}  // namespace headframe
