#include "server/store/stored_merge.hpp"

#include "server/store/columns.hpp"
#include "server/store/constraint_blob.hpp"

namespace headframe {
namespace {

void set_evidence(Evidence& evidence, std::string_view name, double value) {
  for (const EvidenceField& field : evidence_fields())
    if (field.name == name) evidence.*field.member = value;
}

Result<void> read_surveys(Database& db, std::vector<Survey>& surveys) {
  auto read = db.each("SELECT session, T_grid_session FROM surveys ORDER BY choice", [&](const Row& row) {
    surveys.push_back({row.integer(0), pose_from_blob(row.blob(1)), {}});
  });
  for (Survey& survey : surveys) {
    if (!read) return read;
    read = db.each(
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

Change change_of(const Row& row) {
  const bool filled = row.text(2) == to_string(ChangeKind::filled);
  return {filled ? ChangeKind::filled : ChangeKind::excavated,
          {row.real(3), row.real(4), row.real(5)},
          row.real(6),
          row.real(7),
          row.real(8),
          row.integer(9) != 0,
          row.real(10),
          row.real(11)};
}

Result<void> read_alignments(Database& db, std::vector<Alignment>& alignments) {
  std::map<std::pair<SessionId, SessionId>, std::size_t> index;
  auto read = db.each(
      "SELECT a, b, id, state, T_a_b, verdict, T_a_b_runner_up FROM alignments ORDER BY id", [&](const Row& row) {
        Alignment alignment{row.integer(2), row.integer(0), row.integer(1), {}, pose_from_blob(row.blob(4)), {}};
        alignment.state = alignment_state_from(row.text(3)).value_or(AlignmentState::candidate);
        alignment.verdict = alignment_state_from(row.text(5)).value_or(AlignmentState::candidate);
        if (!row.blob(6).empty()) alignment.T_a_b_runner_up = pose_from_blob(row.blob(6));
        index[{alignment.a, alignment.b}] = alignments.size();
        alignments.push_back(alignment);
      });
  if (!read) return read;
  read = db.each("SELECT a, b, name, value FROM evidence", [&](const Row& row) {
    const auto at = index.find({row.integer(0), row.integer(1)});
    if (at != index.end()) set_evidence(alignments[at->second].evidence, row.text(2), row.real(3));
  });
  if (!read) return read;
  return db.each(
      "SELECT a, b, kind, x_a_m, y_a_m, z_a_m, length_m, width_m, height_m, a_is_newer, older_s, newer_s"
      " FROM changes ORDER BY a, b, number",
      [&](const Row& row) {
        const auto at = index.find({row.integer(0), row.integer(1)});
        if (at != index.end()) alignments[at->second].changes.push_back(change_of(row));
      });
}

Result<void> read_atlas(Database& db, Atlas& atlas) {
  auto read = db.each("SELECT coalesce(max(number), 0) FROM revisions",
                      [&](const Row& row) { atlas.revision = static_cast<std::uint64_t>(row.integer(0)); });
  if (!read) return read;
  return db.each("SELECT component, session, T_component_session FROM placed ORDER BY component, session",
                 [&](const Row& row) {
                   if (atlas.components.empty() || atlas.components.back().id != row.integer(0))
                     atlas.components.push_back({row.integer(0), {}});
                   atlas.components.back().placements.push_back({row.integer(1), pose_from_blob(row.blob(2))});
                 });
}

Result<void> read_self_likeness(Database& db, std::map<SessionId, SelfLikeness>& known) {
  return db.each(
      "SELECT session, path_m, clouds, aliases, look_alikes, wanted, similar_places, places FROM self_likeness",
      [&](const Row& row) {
        const SessionId session = row.integer(0);
        SelfLikeness& found = known[session];
        found = {row.real(1), static_cast<std::size_t>(row.integer(2)), row.real(3), row.real(4),
                 row.real(6), like_places_from_blob(row.blob(7)),       {}};
        for (const std::uint64_t sequence : integers_from_blob(row.blob(5)))
          found.wanted.push_back({session, sequence});
      });
}

Result<void> read_closures(Database& db, std::vector<PairClosures>& closures) {
  return db.each("SELECT a, b, places FROM loop_closures ORDER BY a, b", [&](const Row& row) {
    closures.push_back({row.integer(0), row.integer(1), constraints_from_blob(row.blob(2))});
  });
}

Result<void> read_frozen(Database& db, std::vector<FrozenSession>& frozen) {
  return db.each("SELECT session, frame, T_frame_session, places FROM frozen ORDER BY session", [&](const Row& row) {
    frozen.push_back({row.integer(0), row.integer(1), pose_from_blob(row.blob(2)), places_from_blob(row.blob(3))});
  });
}

Result<void> read_decisions(Database& db, std::vector<DecisionRecord>& decisions) {
  return db.each(
      "SELECT id, alignment, decision, T_a_b, seen_points, undone FROM decisions ORDER BY id", [&](const Row& row) {
        const auto decision = decision_from(row.text(2)).value_or(Decision::refuse);  // unknown kind: the cautious one
        decisions.push_back(
            {row.integer(0), row.integer(1), decision, pose_from_blob(row.blob(3)), row.real(4), row.integer(5) != 0});
      });
}

}  // namespace

Result<StoredMerge> read_merge(Database& db) {
  StoredMerge merge;
  auto read = read_alignments(db, merge.alignments);
  if (read) read = read_atlas(db, merge.atlas);
  if (read) read = read_decisions(db, merge.decisions);
  if (read) read = read_self_likeness(db, merge.self_likeness);
  if (read) read = read_closures(db, merge.closures);
  if (read) read = read_frozen(db, merge.frozen);
  if (read)
    read = db.each("SELECT session FROM anchors ORDER BY choice",
                   [&](const Row& row) { merge.anchors.push_back(row.integer(0)); });
  if (!read) return tl::unexpected(read.error());
  return merge;
}

Result<StoredNotes> read_notes(Database& db) {
  StoredNotes notes;
  auto read = db.each("SELECT id, label FROM sessions WHERE label<>''",
                      [&](const Row& row) { notes.labels[row.integer(0)] = row.text(1); });
  if (read)
    read = db.each("SELECT id, note FROM sessions WHERE note<>''",
                   [&](const Row& row) { notes.notes[row.integer(0)] = row.text(1); });
  if (read) read = read_surveys(db, notes.surveys);
  if (!read) return tl::unexpected(read.error());
  return notes;
}

}  // namespace headframe
