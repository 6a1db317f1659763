#include "server/store/schema.hpp"

#include <array>

namespace headframe {
namespace {

// Step i brings version i to i + 1. A step that was released is never changed: add another.
// Poses are blobs of 12 doubles, row-major 3x4; q and w of floats; walls of 180 codes; all little endian.
constexpr std::array steps{
    R"sql(
CREATE TABLE sessions (
  id INTEGER PRIMARY KEY, robot TEXT NOT NULL, session TEXT NOT NULL, sensor_model TEXT NOT NULL, beams INTEGER NOT NULL,
  fov_up_deg REAL NOT NULL, fov_down_deg REAL NOT NULL, max_range_m REAL NOT NULL, family TEXT NOT NULL,
  family_version INTEGER NOT NULL, q_size INTEGER NOT NULL, w_size INTEGER NOT NULL, spool_id INTEGER NOT NULL,
  complete INTEGER NOT NULL DEFAULT 0, attempted_keyframes INTEGER NOT NULL DEFAULT 0, UNIQUE (robot, session));
CREATE TABLE keyframes (
  session INTEGER NOT NULL REFERENCES sessions(id), sequence INTEGER NOT NULL, stamp_s REAL NOT NULL,
  T_local_sensor BLOB NOT NULL, spaciousness_m REAL NOT NULL, q BLOB NOT NULL, w BLOB NOT NULL,
  place_class INTEGER NOT NULL, walls BLOB NOT NULL, point_count INTEGER NOT NULL, PRIMARY KEY (session, sequence))
  WITHOUT ROWID;
CREATE TABLE clouds (
  session INTEGER NOT NULL, sequence INTEGER NOT NULL, encoded BLOB NOT NULL, PRIMARY KEY (session, sequence),
  FOREIGN KEY (session, sequence) REFERENCES keyframes(session, sequence));
CREATE TABLE alignments (
  a INTEGER NOT NULL REFERENCES sessions(id), b INTEGER NOT NULL REFERENCES sessions(id), id INTEGER NOT NULL,
  state TEXT NOT NULL, T_a_b BLOB NOT NULL, PRIMARY KEY (a, b), CHECK (a < b));
CREATE TABLE evidence (
  a INTEGER NOT NULL, b INTEGER NOT NULL, name TEXT NOT NULL, value REAL, PRIMARY KEY (a, b, name)) WITHOUT ROWID;
CREATE TABLE revisions (number INTEGER PRIMARY KEY, time_s REAL NOT NULL);
CREATE TABLE placements (
  revision INTEGER NOT NULL REFERENCES revisions(number), session INTEGER NOT NULL, component INTEGER NOT NULL,
  T_component_session BLOB NOT NULL, PRIMARY KEY (revision, session)) WITHOUT ROWID;
CREATE TABLE merge_order (
  step INTEGER PRIMARY KEY AUTOINCREMENT, revision INTEGER NOT NULL, a INTEGER NOT NULL, b INTEGER NOT NULL,
  state TEXT NOT NULL);
)sql",
    R"sql(
ALTER TABLE alignments ADD COLUMN verdict TEXT NOT NULL DEFAULT 'candidate';
UPDATE alignments SET verdict = CASE state WHEN 'published' THEN 'verified' WHEN 'retracted' THEN 'candidate'
  ELSE state END;
CREATE TABLE decisions (
  id INTEGER PRIMARY KEY, alignment INTEGER NOT NULL, decision TEXT NOT NULL, T_a_b BLOB NOT NULL,
  seen_points REAL, time_s REAL NOT NULL, undone INTEGER NOT NULL DEFAULT 0);
)sql",
    R"sql(
CREATE TABLE robots (
  name TEXT PRIMARY KEY, token_digest BLOB NOT NULL, code_digest BLOB NOT NULL, code_expires_s REAL NOT NULL,
  enrolled_s REAL NOT NULL, revoked INTEGER NOT NULL) WITHOUT ROWID;
ALTER TABLE sessions ADD COLUMN spool_run INTEGER NOT NULL DEFAULT 0;
)sql",
    R"sql(
ALTER TABLE sessions ADD COLUMN label TEXT NOT NULL DEFAULT '';
ALTER TABLE alignments ADD COLUMN T_a_b_runner_up BLOB NOT NULL DEFAULT x'';
CREATE TABLE anchors (session INTEGER PRIMARY KEY, choice INTEGER NOT NULL UNIQUE);
CREATE TABLE surveys (session INTEGER PRIMARY KEY, choice INTEGER NOT NULL UNIQUE, T_grid_session BLOB NOT NULL);
CREATE TABLE survey_points (
  session INTEGER NOT NULL, number INTEGER NOT NULL, name TEXT NOT NULL, x_session_m REAL NOT NULL,
  y_session_m REAL NOT NULL, z_session_m REAL NOT NULL, x_grid_m REAL NOT NULL, y_grid_m REAL NOT NULL,
  z_grid_m REAL NOT NULL, PRIMARY KEY (session, number)) WITHOUT ROWID;
ALTER TABLE robots ADD COLUMN rate_kib_s INTEGER NOT NULL DEFAULT 0;
)sql",
    R"sql(
CREATE TABLE troubles (
  session INTEGER PRIMARY KEY REFERENCES sessions(id), deaths INTEGER NOT NULL, kills INTEGER NOT NULL,
  why_aside TEXT NOT NULL, deleted INTEGER NOT NULL);
)sql",
    R"sql(
ALTER TABLE keyframes ADD COLUMN checksum INTEGER;
)sql",
    // placed: the atlas as it is. placements keeps what changed with each revision, from here on that alone; component
    // 0: the session is in the atlas no more.
    R"sql(
CREATE TABLE self_likeness (
  session INTEGER PRIMARY KEY REFERENCES sessions(id), path_m REAL NOT NULL, clouds INTEGER NOT NULL,
  aliases REAL NOT NULL, look_alikes REAL NOT NULL, wanted BLOB NOT NULL);
ALTER TABLE sessions ADD COLUMN attempted_whole INTEGER NOT NULL DEFAULT 0;
UPDATE sessions SET attempted_whole = complete;
CREATE TABLE placed (session INTEGER PRIMARY KEY, component INTEGER NOT NULL, T_component_session BLOB NOT NULL);
INSERT INTO placed SELECT session, component, T_component_session FROM placements
  WHERE revision = (SELECT max(number) FROM revisions);
)sql",
    R"sql(
CREATE TABLE loop_closures (
  a INTEGER NOT NULL REFERENCES sessions(id),
  b INTEGER NOT NULL REFERENCES sessions(id),
  places BLOB NOT NULL,
  PRIMARY KEY (a, b));
)sql",
    R"sql(
CREATE TABLE changes (
  a INTEGER NOT NULL, b INTEGER NOT NULL, number INTEGER NOT NULL, kind TEXT NOT NULL, x_a_m REAL NOT NULL,
  y_a_m REAL NOT NULL, z_a_m REAL NOT NULL, length_m REAL NOT NULL, width_m REAL NOT NULL, height_m REAL NOT NULL,
  a_is_newer INTEGER NOT NULL, older_s REAL NOT NULL, newer_s REAL NOT NULL, PRIMARY KEY (a, b, number))
  WITHOUT ROWID;
)sql",
    R"sql(
ALTER TABLE sessions ADD COLUMN note TEXT NOT NULL DEFAULT '';
ALTER TABLE sessions ADD COLUMN archived INTEGER NOT NULL DEFAULT 0;
CREATE TABLE frozen (
  session INTEGER PRIMARY KEY REFERENCES sessions(id), frame INTEGER NOT NULL, T_frame_session BLOB NOT NULL,
  places BLOB NOT NULL);
)sql",
    // let_go: clouds that were here and made room.
    R"sql(
CREATE TABLE let_go (
  session INTEGER NOT NULL REFERENCES sessions(id), sequence INTEGER NOT NULL, PRIMARY KEY (session, sequence))
  WITHOUT ROWID;
)sql",
    // robot_sites: where a robot's next session belongs; one without a row: to no site, as the session with ''.
    R"sql(
ALTER TABLE sessions ADD COLUMN site TEXT NOT NULL DEFAULT '';
CREATE TABLE robot_sites (robot TEXT PRIMARY KEY, site TEXT NOT NULL) WITHOUT ROWID;
)sql",
    // Where keyframes lie that a robot's SLAM moved: as merging has them, and as it will once it takes in what robots
    // said. keyframes: how many there were when that was said.
    R"sql(
ALTER TABLE sessions ADD COLUMN pose_update INTEGER NOT NULL DEFAULT 0;
CREATE TABLE moved_poses (
  session INTEGER NOT NULL REFERENCES sessions(id), sequence INTEGER NOT NULL, T_local_sensor BLOB NOT NULL,
  checksum INTEGER NOT NULL, PRIMARY KEY (session, sequence)) WITHOUT ROWID;
CREATE TABLE pose_updates (
  session INTEGER NOT NULL REFERENCES sessions(id), sequence INTEGER NOT NULL, number INTEGER NOT NULL,
  keyframes INTEGER NOT NULL, T_local_sensor BLOB NOT NULL, checksum INTEGER NOT NULL,
  PRIMARY KEY (session, sequence)) WITHOUT ROWID;
)sql",
    // similar_places: what look_alikes was before; look_alikes counts fewer from here on.
    R"sql(
ALTER TABLE self_likeness ADD COLUMN similar_places REAL NOT NULL DEFAULT 0;
UPDATE self_likeness SET similar_places = look_alikes;
INSERT INTO evidence (a, b, name, value) SELECT a, b, 'similar_places', value FROM evidence WHERE name = 'look_alikes'
  ON CONFLICT DO NOTHING;
)sql",
    // places: where a session is like itself; empty for what was found before this was kept.
    R"sql(
ALTER TABLE self_likeness ADD COLUMN places BLOB NOT NULL DEFAULT x'';
)sql",
};

}  // namespace

int schema_version() { return static_cast<int>(steps.size()); }

Result<void> migrate(SqliteDatabase& database) {
  int version = 0;
  auto done = database.each("PRAGMA user_version", [&](const Row& row) { version = static_cast<int>(row.integer(0)); });
  if (!done) return done;
  if (version > schema_version())
    return failure(ErrorCode::incompatible, "the database has schema " + std::to_string(version) +
                                                ", this server knows up to " + std::to_string(schema_version()) +
                                                "; use a newer headframe-server or choose another --data");
  for (; version < schema_version(); ++version) {
    done = database.execute("BEGIN IMMEDIATE;" + std::string(steps.at(static_cast<std::size_t>(version))) +
                            "PRAGMA user_version=" + std::to_string(version + 1) + ";COMMIT;");
    if (done) continue;
    (void)database.execute("ROLLBACK");
    return done;
  }
  return {};
}

}  // namespace headframe
