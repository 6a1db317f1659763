#include "server/operator/changes_json.hpp"

#include <algorithm>
namespace headframe {
namespace {

Json session(SessionId id, double stamp_s, const std::vector<SessionRow>& sessions) {
  const auto row = std::find_if(sessions.begin(), sessions.end(), [&](const SessionRow& r) { return r.id == id; });
  const SessionKey key = row == sessions.end() ? SessionKey{} : row->key;
  return {{"id", id}, {"robot", key.robot}, {"session", key.session}, {"stamp_s", stamp_s}};
}

}  // namespace

Json changes_array(const std::vector<PlacedChange>& changes, const std::vector<SessionRow>& sessions) {
  Json out = Json::array();
  for (const PlacedChange& c : changes)
    out.push_back({{"kind", to_string(c.change.kind)},
                   {"alignment", c.alignment},
                   {"component", c.component == 0 ? Json() : Json(c.component)},
                   {"p", {c.p.x(), c.p.y(), c.p.z()}},
                   {"radius_m", std::max({c.change.length_m, c.change.width_m, c.change.height_m}) / 2},
                   {"size_m", {c.change.length_m, c.change.width_m, c.change.height_m}},
                   {"older", session(c.older, c.change.older_s, sessions)},
                   {"newer", session(c.newer, c.change.newer_s, sessions)}});
  return out;
}

std::string changes_json(const AtlasView& view, const std::vector<SessionRow>& sessions, double since_s) {
  std::vector<const Alignment*> alignments;
  for (const AlignmentRow& row : view.alignments) alignments.push_back(&row.alignment);
  const Json out{{"revision", view.atlas.revision},
                 {"changes", changes_array(changes_since(since_s, alignments, view.atlas), sessions)}};
  return text(out);
}

}  // namespace headframe
