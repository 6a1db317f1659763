#include "server/store/session_writes.hpp"

#include <vector>

#include "server/store/keyframe_row.hpp"
#include "server/store/pose_rows.hpp"

namespace headframe {
namespace {

/// A damaged row is moved as it is; its checksum does not match afterwards either.
Result<void> carry_over_damaged(Database& db, const SplitSession& write, std::uint64_t sequence) {
  return db.run(
      "INSERT INTO keyframes SELECT ?1, sequence - ?2 + 1, stamp_s, T_local_sensor, spaciousness_m, q, w, place_class,"
      " walls, point_count, checksum FROM keyframes WHERE session=?3 AND sequence=?4",
      write.part.id, write.from, write.session, sequence);
}

/// Row by row, because a checksum includes the row's session and number.
Result<void> carry_over_keyframes(Database& db, const SplitSession& write) {
  std::vector<std::pair<std::uint64_t, std::optional<Keyframe>>> rows;
  auto done = db.each(
      select_keyframes() + " WHERE session=? AND sequence>=? ORDER BY sequence",
      [&](const Row& row) { rows.emplace_back(static_cast<std::uint64_t>(row.integer(0)), keyframe_of(row)); },
      write.session, write.from);
  for (auto& [sequence, keyframe] : rows) {
    if (!done) return done;
    if (keyframe) keyframe->sequence = sequence - write.from + 1;
    done = keyframe ? insert_keyframe(db, write.part.id, *keyframe, [](std::uint64_t) {})
                    : carry_over_damaged(db, write, sequence);
  }
  return done;
}

}  // namespace

Result<void> put(Database& db, const PutSession& write) {
  const SessionRecord& s = write.session;
  return db.run(
      "INSERT INTO sessions (id, robot, session, sensor_model, beams, fov_up_deg, fov_down_deg, max_range_m, family,"
      " family_version, q_size, w_size, spool_id, complete, spool_run, site) VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)"
      " ON CONFLICT (id) DO UPDATE SET spool_run=excluded.spool_run",
      s.id, s.key.robot, s.key.session, s.sensor.model, s.sensor.beams, double{s.sensor.fov_up_deg},
      double{s.sensor.fov_down_deg}, double{s.sensor.max_range_m}, s.family.name, s.family.version, s.q_size, s.w_size,
      s.spool_id, int{s.complete}, s.spool_run, s.site);
}

Result<void> put(Database& db, const SplitSession& write) {
  auto done = put(db, PutSession{write.part});
  if (done) done = carry_over_keyframes(db, write);
  if (done) done = carry_over_poses(db, write);
  for (const auto& [table, columns] : {std::pair("clouds", "encoded"), std::pair("let_go", "")}) {
    const std::string more = *columns != '\0' ? std::string(", ") + columns : std::string();
    if (done)
      done = db.run(std::string("INSERT INTO ") + table + " SELECT ?1, sequence - ?2 + 1" + more + " FROM " + table +
                        " WHERE session=?3 AND sequence>=?2",
                    write.part.id, write.from, write.session);
  }
  for (const char* table : {"clouds", "let_go", "keyframes"})
    if (done)
      done =
          db.run(std::string("DELETE FROM ") + table + " WHERE session=? AND sequence>=?", write.session, write.from);
  return done ? put(db, CompleteSession{write.session}) : done;
}

Result<void> put(Database& db, const CompleteSession& write) {
  return db.run("UPDATE sessions SET complete=1 WHERE id=?", write.session);
}

Result<void> put(Database& db, const PutLabel& write) {
  return db.run("UPDATE sessions SET label=? WHERE id=?", write.label, write.session);
}

Result<void> put(Database& db, const PutSessionNote& write) {
  return db.run("UPDATE sessions SET note=? WHERE id=?", write.note, write.session);
}

}  // namespace headframe
