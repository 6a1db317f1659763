#include "server/store/sqlite_store.hpp"

#include <atomic>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include "server/store/backup.hpp"
#include "server/store/columns.hpp"
#include "server/store/data_directory.hpp"
#include "server/store/keyframe_row.hpp"
#include "server/store/schema.hpp"
#include "server/store/sqlite_writer.hpp"

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
  return s;
}

void set_evidence(Evidence& evidence, std::string_view name, double value) {
  for (const EvidenceField& field : evidence_fields())
    if (field.name == name) evidence.*field.member = value;
}

class SqliteStore : public Store {
 public:
  SqliteStore(DataDirectory directory, Database writer, Database reader, const SqliteOptions& options)
      : directory_(std::move(directory)), reader_(std::move(reader)), writer_(std::move(writer), options) {}

  void write(Write write, Done done) override { writer_.write(std::move(write), std::move(done)); }
  StoreLoad load() const override {
    StoreLoad load = writer_.load();
    load.damaged_keyframes = damaged_count_;
    return load;
  }

  Result<std::vector<SessionRecord>> sessions() override {
    std::vector<SessionRecord> sessions;
    const std::lock_guard lock(mutex_);
    auto read = reader_.each(
        "SELECT id, robot, session, sensor_model, beams, fov_up_deg, fov_down_deg, max_range_m, family,"
        " family_version, q_size, w_size, spool_id, complete, attempted_keyframes, spool_run, attempted_whole FROM "
        "sessions ORDER BY id",
        [&](const Row& row) { sessions.push_back(session_of(row)); });
    if (!read) return tl::unexpected(read.error());
    return sessions;
  }

  Result<void> each_keyframe(SessionId session, std::uint64_t first,
                             const std::function<void(Keyframe)>& visit) override {
    const std::lock_guard lock(mutex_);
    std::optional<Keyframe> last;
    std::vector<std::uint64_t> damaged;  // before the first that is whole
    auto read = reader_.each(
        select_keyframes() + " WHERE session=? AND sequence>=? ORDER BY sequence",
        [&](const Row& row) {
          const auto sequence = static_cast<std::uint64_t>(row.integer(0));
          auto keyframe = keyframe_of(row);
          if (!keyframe) note_damage({session, sequence});
          if (!keyframe && !last) return damaged.push_back(sequence);
          if (!keyframe) return visit(stand_in(sequence, *last));
          for (const std::uint64_t earlier : std::exchange(damaged, {})) visit(stand_in(earlier, *keyframe));
          last = *keyframe;
          visit(std::move(*keyframe));
        },
        session, first);
    for (const std::uint64_t sequence : damaged) visit(stand_in(sequence, {}));
    return read;
  }

  Result<std::uint64_t> last_keyframe(SessionId session) override {
    std::uint64_t last = 0;
    const std::lock_guard lock(mutex_);
    auto read = reader_.each(
        "SELECT coalesce(max(sequence), 0) FROM keyframes WHERE session=?",
        [&](const Row& row) { last = static_cast<std::uint64_t>(row.integer(0)); }, session);
    if (!read) return tl::unexpected(read.error());
    return last;
  }

  Result<std::vector<std::uint64_t>> cloud_sequences(SessionId session) override {
    std::vector<std::uint64_t> sequences;
    const std::lock_guard lock(mutex_);
    auto read = reader_.each(
        "SELECT sequence FROM clouds WHERE session=? ORDER BY sequence",
        [&](const Row& row) { sequences.push_back(static_cast<std::uint64_t>(row.integer(0))); }, session);
    if (!read) return tl::unexpected(read.error());
    return sequences;
  }

  Result<std::string> cloud(const KeyframeRef& keyframe) override {
    std::optional<std::string> encoded;
    const std::lock_guard lock(mutex_);
    if (damaged_.contains(keyframe))
      return failure(ErrorCode::not_found, "the row of keyframe " + std::to_string(keyframe.sequence) + " of session " +
                                               std::to_string(keyframe.session) +
                                               " is damaged: where its cloud belongs is not known");
    auto read = reader_.each(
        "SELECT encoded FROM clouds WHERE session=? AND sequence=?", [&](const Row& row) { encoded = row.text(0); },
        keyframe.session, keyframe.sequence);
    if (!read) return tl::unexpected(read.error());
    if (!encoded)
      return failure(ErrorCode::not_found, "no cloud of keyframe " + std::to_string(keyframe.sequence) +
                                               " of session " + std::to_string(keyframe.session) + " is stored");
    return std::move(*encoded);
  }

  Result<std::vector<RobotRecord>> robots() override {
    std::vector<RobotRecord> robots;
    const std::lock_guard lock(mutex_);
    auto read = reader_.each(
        "SELECT name, token_digest, code_digest, code_expires_s, enrolled_s, revoked, rate_kib_s FROM robots"
        " ORDER BY name",
        [&](const Row& row) {
          robots.push_back({row.text(0), row.text(1), row.text(2), row.real(3), row.real(4), row.integer(5) != 0,
                            static_cast<std::uint64_t>(row.integer(6))});
        });
    if (!read) return tl::unexpected(read.error());
    return robots;
  }

  Result<std::vector<TroubleRecord>> troubles() override {
    std::vector<TroubleRecord> troubles;
    const std::lock_guard lock(mutex_);
    auto read = reader_.each("SELECT session, deaths, kills, why_aside, deleted FROM troubles ORDER BY session",
                             [&](const Row& row) {
                               troubles.push_back({row.integer(0), static_cast<int>(row.integer(1)),
                                                   static_cast<int>(row.integer(2)), row.text(3), row.integer(4) != 0});
                             });
    if (!read) return tl::unexpected(read.error());
    return troubles;
  }

  Result<StoredMerge> merge() override {
    StoredMerge merge;
    const std::lock_guard lock(mutex_);
    auto read = read_alignments(merge.alignments);
    if (read) read = read_atlas(merge.atlas);
    if (read) read = read_decisions(merge.decisions);
    if (read) read = read_self_likeness(merge.self_likeness);
    if (read)
      read = reader_.each("SELECT session FROM anchors ORDER BY choice",
                          [&](const Row& row) { merge.anchors.push_back(row.integer(0)); });
    if (!read) return tl::unexpected(read.error());
    return merge;
  }

  Result<StoredNotes> notes() override {
    StoredNotes notes;
    const std::lock_guard lock(mutex_);
    auto read = reader_.each("SELECT id, label FROM sessions WHERE label<>''",
                             [&](const Row& row) { notes.labels[row.integer(0)] = row.text(1); });
    if (read) read = read_surveys(notes.surveys);
    if (!read) return tl::unexpected(read.error());
    return notes;
  }

  Result<std::filesystem::path> backup() override {
    const std::unique_lock one(backup_mutex_, std::try_to_lock);
    if (!one) return failure(ErrorCode::unavailable, "another backup is being made; try again when it is there");
    auto file = directory_.path() / ("headframe.backup-" + std::to_string(++backups_));
    if (auto made = write_backup(directory_.path(), file); !made) return tl::unexpected(made.error());
    return file;
  }

 private:
  /// Under the lock.
  void note_damage(const KeyframeRef& keyframe) {
    damaged_.insert(keyframe);
    damaged_count_ = damaged_.size();
  }

  Result<void> read_surveys(std::vector<Survey>& surveys) {
    auto read = reader_.each("SELECT session, T_grid_session FROM surveys ORDER BY choice", [&](const Row& row) {
      surveys.push_back({row.integer(0), pose_from_blob(row.blob(1)), {}});
    });
    for (Survey& survey : surveys) {
      if (!read) return read;
      read = reader_.each(
          "SELECT name, x_session_m, y_session_m, z_session_m, x_grid_m, y_grid_m, z_grid_m FROM survey_points"
          " WHERE session=? ORDER BY number",
          [&](const Row& row) {
            survey.points.push_back(
                {row.text(0), {row.real(1), row.real(2), row.real(3)}, {row.real(4), row.real(5), row.real(6)}});
          },
          survey.session);
    }
    return read;
  }

  Result<void> read_alignments(std::vector<Alignment>& alignments) {
    std::map<std::pair<SessionId, SessionId>, std::size_t> index;
    auto read = reader_.each(
        "SELECT a, b, id, state, T_a_b, verdict, T_a_b_runner_up FROM alignments ORDER BY id", [&](const Row& row) {
          Alignment alignment{row.integer(2), row.integer(0), row.integer(1), {}, pose_from_blob(row.blob(4)), {}};
          alignment.state = alignment_state_from(row.text(3)).value_or(AlignmentState::candidate);
          alignment.verdict = alignment_state_from(row.text(5)).value_or(AlignmentState::candidate);
          if (!row.blob(6).empty()) alignment.T_a_b_runner_up = pose_from_blob(row.blob(6));
          index[{alignment.a, alignment.b}] = alignments.size();
          alignments.push_back(alignment);
        });
    if (!read) return read;
    return reader_.each("SELECT a, b, name, value FROM evidence", [&](const Row& row) {
      const auto at = index.find({row.integer(0), row.integer(1)});
      if (at != index.end()) set_evidence(alignments[at->second].evidence, row.text(2), row.real(3));
    });
  }

  Result<void> read_atlas(Atlas& atlas) {
    auto read = reader_.each("SELECT coalesce(max(number), 0) FROM revisions",
                             [&](const Row& row) { atlas.revision = static_cast<std::uint64_t>(row.integer(0)); });
    if (!read) return read;
    return reader_.each("SELECT component, session, T_component_session FROM placed ORDER BY component, session",
                        [&](const Row& row) {
                          if (atlas.components.empty() || atlas.components.back().id != row.integer(0))
                            atlas.components.push_back({row.integer(0), {}});
                          atlas.components.back().placements.push_back({row.integer(1), pose_from_blob(row.blob(2))});
                        });
  }

  Result<void> read_self_likeness(std::map<SessionId, SelfLikeness>& known) {
    return reader_.each("SELECT session, path_m, clouds, aliases, look_alikes, wanted FROM self_likeness",
                        [&](const Row& row) {
                          const SessionId session = row.integer(0);
                          SelfLikeness& found = known[session];
                          found = {row.real(1), static_cast<std::size_t>(row.integer(2)), row.real(3), row.real(4), {}};
                          for (const std::uint64_t sequence : integers_from_blob(row.blob(5)))
                            found.wanted.push_back({session, sequence});
                        });
  }

  Result<void> read_decisions(std::vector<DecisionRecord>& decisions) {
    return reader_.each("SELECT id, alignment, decision, T_a_b, seen_points, undone FROM decisions ORDER BY id",
                        [&](const Row& row) {
                          const auto decision =
                              decision_from(row.text(2)).value_or(Decision::refuse);  // of a newer server: the careful
                          decisions.push_back({row.integer(0), row.integer(1), decision, pose_from_blob(row.blob(3)),
                                               row.real(4), row.integer(5) != 0});
                        });
  }

  DataDirectory directory_;
  std::mutex mutex_;  // of reader_ and damaged_
  std::set<KeyframeRef> damaged_;
  std::atomic<std::size_t> damaged_count_ = 0;
  std::mutex backup_mutex_;
  int backups_ = 0;
  Database reader_;
  SqliteWriter writer_;
};

}  // namespace

Result<std::unique_ptr<Store>> open_sqlite_store(const std::filesystem::path& directory, const SqliteOptions& options) {
  auto owned = DataDirectory::open(directory);
  if (!owned) return tl::unexpected(owned.error());
  remove_unfinished_backups(directory);
  const std::string path = (directory / "headframe.db").string();
  auto writer = Database::open(path);
  if (!writer) return tl::unexpected(writer.error());
  constexpr std::uint64_t page_bytes = 16384;
  std::string pragmas =
      "PRAGMA page_size=16384; PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA foreign_keys=ON;";
  if (options.database_bytes > 0)
    pragmas += "PRAGMA max_page_count=" + std::to_string(options.database_bytes / page_bytes + 1) + ";";
  auto done = writer->execute(pragmas);
  if (done) done = migrate(*writer);
  if (!done) return failure(done.error().code, directory.string() + ": " + done.error().message);
  auto reader = Database::open(path);
  if (!reader) return tl::unexpected(reader.error());
  return std::make_unique<SqliteStore>(std::move(*owned), std::move(*writer), std::move(*reader), options);
}

}  // namespace headframe
