#include "server/store/store_writes.hpp"

#include <chrono>
#include <map>

#include "server/store/columns.hpp"
#include "server/store/constraint_blob.hpp"
#include "server/store/keyframe_row.hpp"
#include "server/store/pose_rows.hpp"
#include "server/store/session_writes.hpp"

namespace headframe {
namespace {

Result<void> put(Database& db, const PutKeyframe& write, const Database::Changed& stored) {
  return insert_keyframe(db, write.session, write.keyframe, stored);
}

Result<void> put(Database& db, const PutCloud& write, const Database::Changed& stored) {
  return db.run_counted(
      "INSERT INTO clouds (session, sequence, encoded) SELECT ?1, ?2, ?3 WHERE EXISTS (SELECT 1 FROM keyframes"
      " WHERE session=?1 AND sequence=?2) AND NOT EXISTS (SELECT 1 FROM let_go WHERE session=?1 AND sequence=?2)"
      " ON CONFLICT (session, sequence) DO NOTHING",
      stored, write.keyframe.session, write.keyframe.sequence, Blob{write.encoded});
}

/// Deletes first, so that on a full disk there is room for the records of what was deleted.
Result<void> put(Database& db, const LetGo& write) {
  Result<void> done;
  for (const KeyframeRef& k : write.clouds) {
    if (done) done = db.run("DELETE FROM clouds WHERE session=? AND sequence=?", k.session, k.sequence);
    if (done)
      done = db.run(
          "INSERT INTO let_go SELECT session, sequence FROM keyframes WHERE session=? AND sequence=?"
          " ON CONFLICT (session, sequence) DO NOTHING",
          k.session, k.sequence);
  }
  return done;
}

/// Repeating a keyframe is harmless; another keyframe with the same number is an error.
Result<void> why_not_stored(Database& db, const PutKeyframe& write) {
  const std::string name =
      "keyframe " + std::to_string(write.keyframe.sequence) + " of session " + std::to_string(write.session);
  const char* other = nullptr;
  bool is_there = false;
  auto read = db.each(
      select_keyframes() + " WHERE session=? AND sequence=?",
      [&](const Row& row) {
        const auto stored = keyframe_of(row);  // a damaged one cannot be compared
        other = stored ? difference(*stored, write.keyframe) : nullptr;
        is_there = true;
      },
      write.session, write.keyframe.sequence);
  if (!read || (is_there && other == nullptr)) return read;
  if (is_there)
    return failure(ErrorCode::refused, name + " is stored with " + other +
                                           ": the robot's spool was copied, or its numbers are used twice; begin a new "
                                           "session");
  std::int64_t last = 0;
  read = db.each(
      "SELECT coalesce(max(sequence), 0) FROM keyframes WHERE session=?",
      [&](const Row& row) { last = row.integer(0); }, write.session);
  if (!read) return read;
  return failure(ErrorCode::invalid_argument,
                 name + " would leave a hole after " + std::to_string(last) + ", or its session is not stored");
}

Result<void> why_not_stored(Database& db, const PutCloud& write) {
  bool is_there = false;
  const KeyframeRef& k = write.keyframe;
  auto read = db.each(
      "SELECT sequence FROM clouds WHERE session=?1 AND sequence=?2 UNION ALL"
      " SELECT sequence FROM let_go WHERE session=?1 AND sequence=?2",
      [&](const Row&) { is_there = true; }, k.session, k.sequence);
  if (!read || is_there) return read;
  return failure(ErrorCode::invalid_argument, "a cloud of keyframe " + std::to_string(k.sequence) + " of session " +
                                                  std::to_string(k.session) + ", which is not stored");
}

/// All other writes change something or fail.
template <class Other>
Result<void> why_not_stored(Database&, const Other&) {
  return {};
}

Result<void> put(Database& db, const PutRobot& write) {
  const RobotRecord& r = write.robot;
  return db.run(
      "INSERT INTO robots (name, token_digest, code_digest, code_expires_s, enrolled_s, revoked, rate_kib_s)"
      " VALUES (?,?,?,?,?,?,?) ON CONFLICT (name) DO UPDATE SET token_digest=excluded.token_digest,"
      " code_digest=excluded.code_digest, code_expires_s=excluded.code_expires_s, enrolled_s=excluded.enrolled_s,"
      " revoked=excluded.revoked, rate_kib_s=excluded.rate_kib_s",
      r.name, Blob{r.token_digest}, Blob{r.code_digest}, r.code_expires_s, r.enrolled_s, int{r.revoked}, r.rate_kib_s);
}

Result<void> put(Database& db, const PutRobotSite& write) {
  if (write.site.empty()) return db.run("DELETE FROM robot_sites WHERE robot=?", write.robot);
  return db.run("INSERT INTO robot_sites VALUES (?,?) ON CONFLICT (robot) DO UPDATE SET site=excluded.site",
                write.robot, write.site);
}

Result<void> put_changes(Database& db, const Alignment& alignment) {
  auto done = db.run("DELETE FROM changes WHERE a=? AND b=?", alignment.a, alignment.b);
  for (std::size_t i = 0; done && i < alignment.changes.size(); ++i) {
    const Change& c = alignment.changes[i];
    done = db.run("INSERT INTO changes VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?)", alignment.a, alignment.b, i,
                  to_string(c.kind), c.p_a.x(), c.p_a.y(), c.p_a.z(), c.length_m, c.width_m, c.height_m,
                  int{c.a_is_newer}, c.older_s, c.newer_s);
  }
  return done;
}

Result<void> put_alignment(Database& db, const Alignment& alignment, std::uint64_t revision) {
  const std::string T = pose_blob(alignment.T_a_b);
  const std::string T_runner_up = alignment.T_a_b_runner_up ? pose_blob(*alignment.T_a_b_runner_up) : std::string();
  const std::string_view state = to_string(alignment.state);
  auto done = db.run(
      "INSERT INTO alignments (a, b, id, state, T_a_b, verdict, T_a_b_runner_up) VALUES (?,?,?,?,?,?,?)"
      " ON CONFLICT (a, b) DO UPDATE SET id=excluded.id, state=excluded.state, T_a_b=excluded.T_a_b,"
      " verdict=excluded.verdict, T_a_b_runner_up=excluded.T_a_b_runner_up",
      alignment.a, alignment.b, alignment.id, state, Blob{T}, to_string(alignment.verdict), Blob{T_runner_up});
  for (const EvidenceField& field : evidence_fields()) {
    if (!done) return done;
    done = db.run(
        "INSERT INTO evidence (a, b, name, value) VALUES (?,?,?,?) ON CONFLICT (a, b, name) DO UPDATE SET"
        " value=excluded.value",
        alignment.a, alignment.b, field.name, alignment.evidence.*field.member);
  }
  if (done) done = put_changes(db, alignment);
  if (!done) return done;
  return db.run("INSERT INTO merge_order (revision, a, b, state) VALUES (?,?,?,?)", revision, alignment.a, alignment.b,
                state);
}

double now_s() { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count(); }

Result<void> put_decision(Database& db, const DecisionRecord& record) {
  const std::string T = pose_blob(record.T_a_b);
  return db.run(
      "INSERT INTO decisions (id, alignment, decision, T_a_b, seen_points, time_s, undone) VALUES (?,?,?,?,?,?,?)"
      " ON CONFLICT (id) DO UPDATE SET undone=excluded.undone, T_a_b=excluded.T_a_b",
      record.id, record.alignment, to_string(record.decision), Blob{T}, record.seen_points, now_s(),
      int{record.undone});
}

Result<void> put_atlas(Database& db, const Atlas& atlas) {
  auto done = db.run("INSERT INTO revisions (number, time_s) VALUES (?,?)", atlas.revision, now_s());
  using Placed = std::pair<SessionId, std::string>;  // component, T_component_session
  std::map<SessionId, Placed> before, now;
  if (done)
    done = db.each("SELECT session, component, T_component_session FROM placed", [&](const Row& row) {
      before[row.integer(0)] = {row.integer(1), std::string(row.blob(2))};
    });
  for (const Component& component : atlas.components)
    for (const Placement& placement : component.placements)
      now[placement.session] = {component.id, pose_blob(placement.T_component_session)};
  constexpr SessionId gone = 0;
  for (const auto& [session, placed] : before) {
    if (now.contains(session)) continue;
    if (done) done = db.run("DELETE FROM placed WHERE session=?", session);
    if (done)
      done = db.run("INSERT INTO placements VALUES (?,?,?,?)", atlas.revision, session, gone, Blob{placed.second});
  }
  for (const auto& [session, placed] : now) {
    if (const auto was = before.find(session); was != before.end() && was->second == placed) continue;
    const auto& [component, T] = placed;
    if (done)
      done = db.run(
          "INSERT INTO placed VALUES (?,?,?) ON CONFLICT (session) DO UPDATE SET component=excluded.component,"
          " T_component_session=excluded.T_component_session",
          session, component, Blob{T});
    if (done) done = db.run("INSERT INTO placements VALUES (?,?,?,?)", atlas.revision, session, component, Blob{T});
  }
  return done;
}

Result<void> put_self_likeness(Database& db, SessionId session, const SelfLikeness& found) {
  std::vector<std::uint64_t> wanted;
  for (const KeyframeRef& keyframe : found.wanted) wanted.push_back(keyframe.sequence);
  const std::string sequences = integers_blob(wanted), places = like_places_blob(found.places);
  return db.run(
      "INSERT INTO self_likeness VALUES (?,?,?,?,?,?,?,?) ON CONFLICT (session) DO UPDATE SET path_m=excluded.path_m,"
      " clouds=excluded.clouds, aliases=excluded.aliases, look_alikes=excluded.look_alikes, wanted=excluded.wanted,"
      " similar_places=excluded.similar_places, places=excluded.places",
      session, found.path_m, found.clouds, found.aliases, found.look_alikes, Blob{sequences}, found.similar_places,
      Blob{places});
}

Result<void> put(Database& db, const DropSurvey& write) {
  auto done = db.run("DELETE FROM survey_points WHERE session=?", write.session);
  if (done) done = db.run("DELETE FROM surveys WHERE session=?", write.session);
  return done;
}

Result<void> put(Database& db, const PutSurvey& write) {
  const Survey& survey = write.survey;
  auto done = put(db, DropSurvey{survey.session});
  const std::string T = pose_blob(survey.T_grid_session);
  if (done)
    done =
        db.run("INSERT INTO surveys SELECT ?, coalesce(max(choice), 0) + 1, ? FROM surveys", survey.session, Blob{T});
  for (std::size_t i = 0; done && i < survey.points.size(); ++i) {
    const auto& [name, s, g] = survey.points[i];
    done = db.run("INSERT INTO survey_points VALUES (?,?,?,?,?,?,?,?,?)", survey.session, i, name, s.x(), s.y(), s.z(),
                  g.x(), g.y(), g.z());
  }
  return done;
}

Result<void> delete_content(Database& db, SessionId session) {
  auto done = put(db, DropSurvey{session});
  for (const char* table :
       {"clouds", "let_go", "moved_poses", "pose_updates", "keyframes", "anchors", "self_likeness", "frozen"})
    if (done) done = db.run("DELETE FROM " + std::string(table) + " WHERE session=?", session);
  if (done) done = db.run("DELETE FROM loop_closures WHERE a=? OR b=?", session, session);
  return done;
}

Result<void> put(Database& db, const PutTrouble& write) {
  const TroubleRecord& t = write.trouble;
  auto done = db.run(
      "INSERT INTO troubles VALUES (?,?,?,?,?) ON CONFLICT (session) DO UPDATE SET deaths=excluded.deaths,"
      " kills=excluded.kills, why_aside=excluded.why_aside, deleted=excluded.deleted",
      t.session, t.deaths, t.kills, t.why_aside, int{t.deleted});
  return done && t.deleted ? delete_content(db, t.session) : done;
}

Result<void> put_frozen(Database& db, const FrozenSession& frozen) {
  const std::string T = pose_blob(frozen.T_frame_session), places = places_blob(frozen.places);
  return db.run(
      "INSERT INTO frozen VALUES (?,?,?,?) ON CONFLICT (session) DO UPDATE SET frame=excluded.frame,"
      " T_frame_session=excluded.T_frame_session, places=excluded.places",
      frozen.session, frozen.frame, Blob{T}, Blob{places});
}

Result<void> put(Database& db, const PutMerge& write) {
  std::uint64_t revision = 0;
  auto done = db.each("SELECT coalesce(max(number), 0) FROM revisions",
                      [&](const Row& row) { revision = static_cast<std::uint64_t>(row.integer(0)); });
  if (done && write.atlas) {
    revision = write.atlas->revision;
    done = put_atlas(db, *write.atlas);
  }
  for (const Alignment& alignment : write.changed) {
    if (!done) return done;
    done = put_alignment(db, alignment, revision);
  }
  for (const DecisionRecord& record : write.decided) {
    if (!done) return done;
    done = put_decision(db, record);
  }
  for (const auto& [session, found] : write.self_likeness)
    if (done) done = put_self_likeness(db, session, found);
  for (const PairClosures& pair : write.closures) {
    if (!done) break;
    const std::string places = constraints_blob(pair.places);
    done = db.run(
        "INSERT INTO loop_closures (a, b, places) VALUES (?,?,?) ON CONFLICT (a, b) DO UPDATE SET "
        "places=excluded.places",
        pair.a, pair.b, Blob{places});
  }
  if (done && write.anchored != 0)
    done = db.run(
        "INSERT INTO anchors SELECT ?, coalesce(max(choice), 0) + 1 FROM anchors WHERE true"
        " ON CONFLICT (session) DO UPDATE SET choice=excluded.choice",
        write.anchored);
  for (const FrozenSession& frozen : write.frozen)
    if (done) done = put_frozen(db, frozen);
  if (done && write.thawed != 0) done = db.run("DELETE FROM frozen WHERE session=?", write.thawed);
  if (done && write.trouble) done = put(db, *write.trouble);
  if (done && write.archived)
    done = db.run("UPDATE sessions SET archived=? WHERE id=?", int{write.archived->archived}, write.archived->session);
  if (done && write.site) done = db.run("UPDATE sessions SET site=? WHERE id=?", write.site->site, write.site->session);
  if (done && write.moved) done = put(db, *write.moved);
  if (!done || write.attempted == 0) return done;
  return db.run("UPDATE sessions SET attempted_keyframes=?, attempted_whole=? WHERE id=?", write.attempted_keyframes,
                int{write.attempted_whole}, write.attempted);
}

template <class Other>
Result<void> put(Database& db, const Other& write, const Database::Changed&) {
  return put(db, write);
}

}  // namespace

Result<void> apply(Database& db, const Write& write, const Database::Changed& stored) {
  return std::visit([&](const auto& w) { return put(db, w, stored); }, write);
}

Result<void> why_nothing_changed(Database& database, const Write& write) {
  return std::visit([&](const auto& w) { return why_not_stored(database, w); }, write);
}

std::size_t size_bytes(const Write& write) {
  constexpr std::size_t small = 1024;
  if (const auto* cloud = std::get_if<PutCloud>(&write)) return cloud->encoded.size() + small;
  if (const auto* update = std::get_if<PutPoses>(&write)) {
    std::size_t poses = 0;
    for (const auto& [session, of] : update->sessions) poses += of.poses.size();
    return poses * sizeof(KeyframePose) + small;
  }
  if (const auto* keyframe = std::get_if<PutKeyframe>(&write)) {
    const Descriptor& d = keyframe->keyframe.descriptor;
    return (d.q.size() + d.w.size()) * sizeof(float) + small;
  }
  return small;
}

}  // namespace headframe
