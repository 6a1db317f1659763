// How operators maintain sessions: archive, freeze, sites, notes, and what depends on a session.
#include <nlohmann/json.hpp>

#include "server/atlas/dependents.hpp"
#include "server/operator/api_json.hpp"
#include "server/operator/routes.hpp"

namespace headframe::routes {
namespace {

using Json = nlohmann::json;
using Callback = std::function<void(const Result<void>&)>;

/// Applies `act` to the session in the path, and answers with the changed session.
Result<Reply> tend(const Query& query, const Context& context, std::function<void(Station&, SessionId, Callback)> act) {
  const auto row = session_in_path(query, context);
  if (!row) return tl::unexpected(row.error());
  return Later{[&station = context.station, id = row->id, act = std::move(act)](auto answer) {
    act(station, id, [&station, id, answer = std::move(answer)](const Result<void>& done) {
      if (!done) return answer(error_reply(done.error()));
      for (const SessionRow& now : station.sessions())
        if (now.id == id) return answer(json(session_json(now, station.atlas().atlas)));
      answer(error_reply({ErrorCode::not_found, "the session is gone"}));
    });
  }};
}

}  // namespace

Result<Reply> archive(const Query& query, const Context& context) {
  return tend(query, context, [](Station& s, SessionId id, Callback done) { s.archive(id, true, std::move(done)); });
}

Result<Reply> restore_session(const Query& query, const Context& context) {
  return tend(query, context, [](Station& s, SessionId id, Callback done) { s.archive(id, false, std::move(done)); });
}

Result<Reply> freeze(const Query& query, const Context& context) {
  return tend(query, context, [](Station& s, SessionId id, Callback done) { s.freeze(id, true, std::move(done)); });
}

Result<Reply> thaw(const Query& query, const Context& context) {
  return tend(query, context, [](Station& s, SessionId id, Callback done) { s.freeze(id, false, std::move(done)); });
}

/// Without the parameter the session belongs to no site.
Result<Reply> set_site(const Query& query, const Context& context) {
  const auto given = query.find("site");
  return tend(query, context,
              [site = given == query.end() ? std::string() : given->second](Station& s, SessionId id, Callback done) {
                s.set_site(id, site, std::move(done));
              });
}

/// The note is the body, or the parameter "text".
Result<Reply> note_session(const Query& query, const Context& context) {
  const auto text = query.find("text");
  const std::string note(text == query.end() ? context.body : std::string_view(text->second));
  return tend(query, context, [note](Station& s, SessionId id, Callback done) { s.note(id, note, std::move(done)); });
}

Result<Reply> dependents(const Query& query, const Context& context) {
  const auto row = session_in_path(query, context);
  if (!row) return tl::unexpected(row.error());
  const AtlasView view = context.station.atlas();
  std::map<SessionId, SessionKey> keys;
  for (const SessionRow& other : context.station.sessions()) keys[other.id] = other.key;
  std::vector<Alignment> alignments;
  alignments.reserve(view.alignments.size());
  for (const AlignmentRow& known : view.alignments) alignments.push_back(known.alignment);
  const auto names = [&](const std::vector<SessionId>& ids) {
    Json out = Json::array();
    for (const SessionId id : ids) out.push_back({{"robot", keys[id].robot}, {"session", keys[id].session}});
    return out;
  };
  const Dependents found = dependents_of(row->id, view.atlas, alignments);
  Json parts = Json::array();
  for (const auto& part : found.parts) parts.push_back(names(part));
  const auto surveys = context.station.surveys();
  const bool surveyed =
      std::any_of(surveys.begin(), surveys.end(), [&](const Survey& s) { return s.session == row->id; });
  return json(Json{{"keyframes", row->keyframes},
                   {"clouds", row->clouds},
                   {"connected", row->connected},
                   {"surveyed", surveyed},
                   {"frozen", row->frozen},
                   {"anchor", found.is_anchor},
                   {"merged_with", names(found.merged_with)},
                   {"parts", std::move(parts)}}
                  .dump() +
              "\n");
}

}  // namespace headframe::routes
