#include "server/operator/event_diff.hpp"

#include <map>

#include "server/operator/api_json.hpp"

namespace headframe {
namespace {

bool same(const Pending& x, const Pending& y) {
  return x.attempts == y.attempts && x.keyframes == y.keyframes && x.awaited_submaps == y.awaited_submaps;
}

bool same(const Alignment& x, const Alignment& y) {
  return x.state == y.state && x.ruling == y.ruling && x.objection.has_value() == y.objection.has_value() &&
         x.T_a_b.matrix() == y.T_a_b.matrix() && x.evidence.probability == y.evidence.probability &&
         x.evidence.runner_up == y.evidence.runner_up;
}

void add_sessions(const StationLook& before, const StationLook& after, std::vector<std::string>& events) {
  std::map<SessionId, const SessionRow*> was;
  for (const SessionRow& row : before.sessions) was[row.id] = &row;
  for (const SessionRow& row : after.sessions) {
    const auto known = was.find(row.id);
    const SessionRow old = known == was.end() ? SessionRow{} : *known->second;
    if (row.connected != old.connected)
      events.push_back(session_event(row.connected ? "robot_connected" : "robot_left", row));
    if (known == was.end() || row.keyframes != old.keyframes || row.clouds != old.clouds || row.moves != old.moves ||
        row.complete != old.complete || row.why_cut != old.why_cut)
      events.push_back(session_event("keyframes", row));
    if (row.live && (!old.live || row.live->news != old.live->news)) events.push_back(session_event("live", row));
    if (row.label != old.label || row.archived != old.archived || row.frozen != old.frozen || row.note != old.note ||
        row.site != old.site)
      events.push_back(session_event("renamed", row));
  }
}

void add_alignments(const AtlasView& before, const AtlasView& after, std::vector<std::string>& events) {
  std::map<AlignmentId, const Alignment*> was;
  for (const AlignmentRow& row : before.alignments) was[row.alignment.id] = &row.alignment;
  for (const AlignmentRow& row : after.alignments) {
    const auto known = was.find(row.alignment.id);
    if (known == was.end() || !same(*known->second, row.alignment)) events.push_back(alignment_event(row));
  }
}

}  // namespace

StationLook look_at(const Station& station) {
  AtlasView view = station.atlas();  // read before the sessions, so that their list has all it names
  return {station.sessions(), std::move(view), station.pending()};
}

std::vector<std::string> events_between(const StationLook& before, const StationLook& after) {
  std::vector<std::string> events;
  add_sessions(before, after, events);
  add_alignments(before.view, after.view, events);
  if (before.view.atlas.revision != after.view.atlas.revision) events.push_back(revision_event(after.view.atlas));
  if (!same(before.pending, after.pending)) events.push_back(pending_event(after.pending));
  return events;
}

std::string snapshot_event(const StationLook& look) {
  const WaitOutcome now{look.pending, false};
  return R"({"type":"snapshot","sessions":)" + sessions_json(look.sessions, look.view.atlas) + R"(,"atlas":)" +
         atlas_json(look.view, look.sessions, &now) + "}";
}

}  // namespace headframe
