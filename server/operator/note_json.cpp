#include "server/operator/note_json.hpp"

#include "server/operator/json_text.hpp"

namespace headframe {
namespace {

constexpr std::uint64_t most_note_id = 1ULL << 53U;  // JSON readers represent larger integers inexactly

Json note_object(const Note& note) {
  Json places = Json::array();
  for (const NotePlace& place : note.places)
    places.push_back({{"session_id", place.session}, {"p_session", place.p_session}});
  return {{"id", note.id},     {"kind", note.kind},
          {"text", note.text}, {"by", note.by.empty() ? Json() : Json(note.by)},
          {"at_s", note.at_s}, {"places", std::move(places)}};
}

tl::unexpected<Error> broken_note(const std::string& what) {
  return failure(ErrorCode::bad_input, "the note: " + what +
                                           "; give {\"kind\": \"note\", \"text\": .., \"places\": [{\"session_id\": "
                                           "1, \"p_session\": [x, y, z]}, ...]}");
}

std::optional<NotePlace> place_of(const Json& row) {
  if (!row.is_object() || !row.contains("session_id") || !row["session_id"].is_number_integer()) return std::nullopt;
  if (!row.contains("p_session") || !row["p_session"].is_array() || row["p_session"].size() != 3) return std::nullopt;
  NotePlace place{row["session_id"].get<SessionId>(), {}};
  for (std::size_t i = 0; i < 3; ++i) {
    if (!row["p_session"][i].is_number()) return std::nullopt;
    place.p_session.at(i) = row["p_session"][i].get<double>();
  }
  return place;
}

std::string words_of(const Json& json, const char* name) {
  return json.contains(name) && json[name].is_string() ? json[name].get<std::string>() : std::string();
}

Result<Note> note_of(const Json& json) {
  if (!json.is_object()) return broken_note("this is no JSON object");
  Note note{words_of(json, "kind"), words_of(json, "text"), {}, {}};
  if (!json.contains("places") || !json["places"].is_array()) return broken_note("it has no places");
  for (const Json& row : json["places"]) {
    const auto place = place_of(row);
    if (!place) return broken_note("place " + std::to_string(note.places.size() + 1) + " can not be read");
    note.places.push_back(*place);
  }
  return note;
}

}  // namespace

std::string note_json(const Note& note) { return text(note_object(note)); }

std::string notes_json(const std::vector<Note>& notes) {
  Json rows = Json::array();
  for (const Note& note : notes) rows.push_back(note_object(note));
  return text({{"notes", std::move(rows)}});
}

Result<Note> note_from_json(std::string_view body) { return note_of(Json::parse(body, nullptr, false)); }

std::string removal_line(std::uint64_t id) { return text({{"removed", id}}); }

std::optional<NoteLine> note_line(std::string_view line) {
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  const auto id = [&](const char* name) -> std::uint64_t {
    return json.contains(name) && json[name].is_number_unsigned() ? json[name].get<std::uint64_t>() : 0;
  };
  if (id("removed") > most_note_id || id("id") > most_note_id) return std::nullopt;
  if (json.contains("removed")) return NoteLine{{}, id("removed")};
  auto note = note_of(json);
  if (!note || id("id") == 0 || !json.contains("at_s") || !json["at_s"].is_number()) return std::nullopt;
  note->id = id("id");
  note->at_s = json["at_s"].get<double>();
  note->by = words_of(json, "by");
  return NoteLine{std::move(*note), 0};
}

}  // namespace headframe
