#include "server/operator/api_json.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "server/operator/changes_json.hpp"
#include "server/operator/json_text.hpp"
#include "server/operator/session_totals.hpp"

namespace headframe {
namespace {

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json transform(const Pose& T) {
  Json out = Json::array();
  for (const double value : row_major(T)) out.push_back(number(value));
  return out;
}

Json session(const SessionKey& key) { return {{"robot", key.robot}, {"session", key.session}}; }

Json pending_object(const Pending& pending) {
  return {
      {"attempts", pending.attempts}, {"keyframes", pending.keyframes}, {"awaited_submaps", pending.awaited_submaps}};
}

Json objection_object(const std::optional<Objection>& by) {
  if (!by) return nullptr;
  return {{"a", by->a}, {"b", by->b}, {"violation", number(by->violation)}};
}

Json alignment_object(const AlignmentRow& row) {
  Json evidence = Json::object();
  for (const EvidenceField& field : evidence_fields())
    evidence[std::string(field.name)] = number(row.alignment.evidence.*field.member);
  return {{"id", row.alignment.id},
          {"a", session(row.a)},
          {"b", session(row.b)},
          {"state", to_string(row.alignment.state)},
          {"verdict", to_string(row.alignment.verdict)},
          {"decision", to_string(row.alignment.ruling)},
          {"T_a_b", transform(row.alignment.T_a_b)},
          {"objection", objection_object(row.alignment.objection)},
          {"evidence", std::move(evidence)}};
}

Json live_object(const std::optional<LiveRow>& live) {
  if (!live) return nullptr;
  const LiveState& state = live->state;
  return {{"age_s", number(live->age_s)},
          {"stamp_s", number(state.stamp_s)},
          {"T_session_sensor", state.T_local_sensor ? transform(*state.T_local_sensor) : Json()},
          {"battery", state.battery ? number(*state.battery) : Json()},
          {"health", state.health.empty() ? Json() : Json(state.health)}};
}

Json session_object(const SessionRow& row) {
  return {{"robot", row.key.robot},
          {"session", row.key.session},
          {"id", row.id},
          {"label", row.label.empty() ? Json() : Json(row.label)},
          {"family", {{"name", row.family.name}, {"version", row.family.version}}},
          {"sensor",
           {{"model", row.sensor.model},
            {"beams", row.sensor.beams},
            {"fov_up_deg", number(row.sensor.fov_up_deg)},
            {"fov_down_deg", number(row.sensor.fov_down_deg)},
            {"max_range_m", number(row.sensor.max_range_m)}}},
          {"connected", row.connected},
          {"complete", row.complete},
          {"why_cut", row.why_cut.empty() ? Json() : Json(row.why_cut)},
          {"why_aside", row.why_aside.empty() ? Json() : Json(row.why_aside)},
          {"archived", row.archived},
          {"frozen", row.frozen},
          {"site", row.site.empty() ? Json() : Json(row.site)},
          {"note", row.note.empty() ? Json() : Json(row.note)},
          {"keyframes", row.keyframes},
          {"moves", row.moves},
          {"clouds", row.clouds},
          {"bytes_received", row.bytes_received},
          {"backlog", row.backlog},
          {"bytes_per_s", number(row.bytes_per_s)},
          {"link_age_s", row.link_age_s >= 0 ? number(row.link_age_s) : Json()},
          {"live", live_object(row.live)},
          {"distance_m", number(row.distance_m)},
          {"trigger_to_transform_ms", row.trigger_to_transform_ms >= 0 ? number(row.trigger_to_transform_ms) : Json()}};
}

bool came_to_nothing(const Alignment& k) { return k.state == AlignmentState::rejected && k.ruling == Ruling::none; }

SessionId component_of(const Atlas& atlas, SessionId session_id) {
  for (const Component& component : atlas.components)
    for (const Placement& placement : component.placements)
      if (placement.session == session_id) return component.id;
  return 0;
}

}  // namespace

std::vector<double> row_major(const Pose& T) {
  std::vector<double> out;
  out.reserve(16);
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) out.push_back(T.matrix()(row, column));
  return out;
}

std::string session_json(const SessionRow& row, const Atlas& atlas) {
  Json object = session_object(row);
  const SessionId component = component_of(atlas, row.id);
  object["component"] = component == 0 ? Json() : Json(component);
  return text(object);
}

std::string anchor_json(const Atlas& atlas, SessionId session) {
  return text({{"revision", atlas.revision}, {"component", component_of(atlas, session)}});
}

std::string session_event(std::string_view type, const SessionRow& row) {
  Json event{{"type", type}};
  event.update(session_object(row));
  return text(event);
}

std::string alignment_event(const AlignmentRow& row) {
  return text({{"type", "alignment"}, {"alignment", alignment_object(row)}});
}

std::string revision_event(const Atlas& atlas) {
  return text({{"type", "revision"}, {"revision", atlas.revision}, {"components", atlas.components.size()}});
}

std::string pending_event(const Pending& pending) {
  return text({{"type", "pending"}, {"pending", pending_object(pending)}});
}

std::string error_json(const Error& error) {
  return text({{"error", {{"code", to_string(error.code)}, {"message", error.message}}}});
}

std::string status_json(const std::vector<SessionRow>& sessions, const AtlasView& view, const Pending& pending,
                        const LinkHealth& links, double uptime_s) {
  const SessionTotals totals = totals_of(sessions);
  Json states = Json::object();
  for (const AlignmentRow& row : view.alignments) {
    Json& count = states[std::string(to_string(row.alignment.state))];
    count = count.is_null() ? 1 : count.get<int>() + 1;
  }
  return text({{"version", HEADFRAME_VERSION},
               {"uptime_s", number(uptime_s)},
               {"revision", view.atlas.revision},
               {"components", view.atlas.components.size()},
               {"sessions", sessions.size()},
               {"connected", totals.connected},
               {"keyframes", totals.keyframes},
               {"clouds", totals.clouds},
               {"bytes_received", totals.bytes_received},
               {"alignments", std::move(states)},
               {"pending", pending_object(pending)},
               {"links",
                {{"hold", links.hold.empty() ? Json(nullptr) : Json(links.hold)},
                 {"queued_bytes", links.queued_bytes},
                 {"refused", links.refused},
                 {"replaced", links.replaced},
                 {"failed", links.failed},
                 {"stuck", links.stuck},
                 {"held_back", links.held_back},
                 {"refused_clouds", links.refused_clouds}}}});
}

std::string sessions_json(const std::vector<SessionRow>& sessions, const Atlas& atlas) {
  std::map<SessionId, SessionId> component_of;
  for (const Component& component : atlas.components)
    for (const Placement& placement : component.placements) component_of[placement.session] = component.id;
  Json rows = Json::array();
  for (const SessionRow& row : sessions) {
    const auto component = component_of.find(row.id);
    Json object = session_object(row);
    object["component"] = component == component_of.end() ? Json(nullptr) : Json(component->second);
    rows.push_back(std::move(object));
  }
  return text({{"sessions", std::move(rows)}});
}

std::string alignments_json(const AtlasView& view, const AlignmentChoice& choice) {
  std::vector<const AlignmentRow*> chosen;
  std::size_t rejected = 0;
  for (const AlignmentRow& row : view.alignments) {
    if (choice.state && row.alignment.state != *choice.state) continue;
    if (choice.id && row.alignment.id != *choice.id) continue;
    chosen.push_back(&row);
    rejected += came_to_nothing(row.alignment) ? 1 : 0;
  }
  const std::size_t left_out = rejected - std::min(rejected, choice.most_rejected);
  std::size_t older = left_out;  // alignments are in the order in which they were first tried
  Json rows = Json::array();
  for (const AlignmentRow* row : chosen) {
    if (older > 0 && came_to_nothing(row->alignment))
      --older;
    else
      rows.push_back(alignment_object(*row));
  }
  return text({{"revision", view.atlas.revision}, {"left_out", left_out}, {"alignments", std::move(rows)}});
}

std::string alignment_json(const AtlasView& view, AlignmentId id) {
  for (const AlignmentRow& row : view.alignments)
    if (row.alignment.id == id) return text({{"revision", view.atlas.revision}, {"alignment", alignment_object(row)}});
  return error_json({ErrorCode::not_found, "there is no alignment " + std::to_string(id)});
}

std::string explanation_json(const SessionRow& a, const SessionRow& b, const AlignmentRow* alignment,
                             const Explanation& explanation, const Atlas& atlas) {
  Json findings = Json::array();
  for (const Finding& finding : explanation.findings)
    findings.push_back({{"evidence", finding.evidence},
                        {"value", number(finding.log_odds)},
                        {"speaks", to_string(finding.speaks)},
                        {"text", finding.text},
                        {"would_suffice", finding.would_suffice}});
  Json gates = Json::array();
  for (const Gate& gate : explanation.gates)
    gates.push_back({{"gate", gate.name}, {"passed", gate.passed}, {"text", gate.text}});
  return text({{"a", session(a.key)},
               {"b", session(b.key)},
               {"outcome", explanation.outcome},
               {"decision", explanation.decision},
               {"findings", std::move(findings)},
               {"gates", std::move(gates)},
               {"missing", explanation.missing},
               {"changes", alignment ? changes_array(changes_of(alignment->alignment, atlas), {a, b}) : Json::array()},
               {"alignment", alignment ? alignment_object(*alignment) : Json(nullptr)}});
}

std::string atlas_json(const AtlasView& view, const std::vector<SessionRow>& sessions, const WaitOutcome* wait) {
  std::map<SessionId, const SessionRow*> rows;
  for (const SessionRow& row : sessions) rows[row.id] = &row;
  const auto name = [&](SessionId id) { return rows.contains(id) ? session(rows[id]->key) : session({}); };
  Json components = Json::array();
  for (const Component& component : view.atlas.components) {
    Json placed = Json::array();
    for (const Placement& placement : component.placements) {
      Json entry = name(placement.session);
      entry["id"] = placement.session;
      const auto row = rows.find(placement.session);
      entry["label"] = row == rows.end() || row->second->label.empty() ? Json() : Json(row->second->label);
      entry["T_component_session"] = transform(placement.T_component_session);
      placed.push_back(std::move(entry));
    }
    Json provisional = Json::array();
    for (const ProvisionalPlacement& placement : component.provisional) {
      Json entry = name(placement.session);
      entry.update({{"id", placement.session},
                    {"T_component_session", transform(placement.T_component_session)},
                    {"probability", placement.probability},
                    {"awaited_m", placement.awaited_m}});
      provisional.push_back(std::move(entry));
    }
    components.push_back({{"id", component.id},
                          {"anchor", name(component.id)},
                          {"sessions", std::move(placed)},
                          {"provisional", std::move(provisional)}});
  }
  Json alignments = Json::array();
  std::size_t rejected = 0;
  for (const AlignmentRow& row : view.alignments) {
    if (came_to_nothing(row.alignment))
      ++rejected;
    else
      alignments.push_back(alignment_object(row));
  }
  Json out{{"revision", view.atlas.revision},
           {"components", std::move(components)},
           {"alignments", std::move(alignments)},
           {"rejected", rejected}};
  if (wait) {
    out["pending"] = pending_object(wait->pending);
    out["waited_out"] = wait->waited_out;
  }
  return text(out);
}

}  // namespace headframe
