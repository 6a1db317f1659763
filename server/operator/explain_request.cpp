#include "server/operator/explain_request.hpp"

#include <algorithm>
#include <optional>

#include "server/atlas/explain.hpp"
#include "server/operator/api_json.hpp"

namespace headframe {
namespace {

std::string full_name(const SessionRow& row) { return row.key.robot + "/" + row.key.session; }

ExplainedSession explained(const SessionRow& row) {
  return {full_name(row), row.family,  row.distance_m, row.keyframes, row.clouds, row.complete,
          row.connected,  row.why_cut, row.why_aside,  row.archived,  row.site};
}

bool together(const Atlas& atlas, SessionId a, SessionId b) {
  return std::any_of(atlas.components.begin(), atlas.components.end(), [&](const Component& component) {
    return placement_in(component, a) && placement_in(component, b);
  });
}

/// Requires a.id < b.id. `known` is null if the pair has not been tried yet.
std::string explained_json(const Station& station, const AtlasView& view, const SessionRow& a, const SessionRow& b,
                           const AlignmentRow* known) {
  const auto sessions = station.sessions();
  const auto name = [&](SessionId id) {
    const auto named = std::find_if(sessions.begin(), sessions.end(), [&](const auto& s) { return s.id == id; });
    return named == sessions.end() ? "session " + std::to_string(id) : full_name(*named);
  };
  const Explanation explanation = explain(explained(a), explained(b), known ? &known->alignment : nullptr,
                                          together(view.atlas, a.id, b.id), station.merge_config(), name);
  return explanation_json(a, b, known, explanation, view.atlas);
}

}  // namespace

Result<SessionRow> find_session(const std::vector<SessionRow>& sessions, const std::string& name) {
  const SessionRow* of_robot = nullptr;
  std::size_t runs = 0;
  std::string there;
  for (const SessionRow& row : sessions) {
    if (full_name(row) == name) return row;
    if (row.key.robot == name) of_robot = &row, ++runs;
    there += (there.empty() ? "" : ", ") + full_name(row);
  }
  if (runs == 1) return *of_robot;
  const std::string problem =
      runs == 0 ? "there is no session \"" + name + "\"" : "robot \"" + name + "\" has several sessions; say which";
  return failure(ErrorCode::not_found, problem + (there.empty() ? "; no session yet" : "; there are " + there));
}

Result<std::string> explain_request(const Station& station, const std::string& a, const std::string& b) {
  const AtlasView view = station.atlas();
  const auto sessions = station.sessions();
  auto first = find_session(sessions, a), second = find_session(sessions, b);
  if (!first) return tl::unexpected(first.error());
  if (!second) return tl::unexpected(second.error());
  if (first->id == second->id)
    return failure(ErrorCode::invalid_argument, full_name(*first) + " is one session; name two");
  if (first->id > second->id) std::swap(first, second);
  const auto row = std::find_if(view.alignments.begin(), view.alignments.end(), [&](const AlignmentRow& r) {
    return r.alignment.a == first->id && r.alignment.b == second->id;
  });
  return explained_json(station, view, *first, *second, row == view.alignments.end() ? nullptr : &*row);
}

std::string explain_placement(const Station& station, const SessionRow& a, const SessionRow& b,
                              const Alignment& placement) {
  const auto& [first, second] = std::minmax(a, b, [](const SessionRow& s, const SessionRow& t) { return s.id < t.id; });
  const AlignmentRow row{placement, first.key, second.key};
  return explained_json(station, station.atlas(), first, second, &row);
}

}  // namespace headframe
