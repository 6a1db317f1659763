#pragma once
// Notes as JSON: in answers, in requests, and in the file that keeps them. Pure.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/operator/note_book.hpp"

namespace headframe {

/// {"id", "kind", "text", "by", "at_s", "places": [{"session_id", "p_session"}]}, one line.
std::string note_json(const Note& note);
/// {"notes": [...]}
std::string notes_json(const std::vector<Note>& notes);
/// {"kind", "text", "places"}; bad_input says what is wrong. What a note has to be is NoteBook's to say.
Result<Note> note_from_json(std::string_view body);

/// A line of the file: a note, or the id of one that was taken away.
struct NoteLine {
  Note note;
  std::uint64_t removed = 0;  // 0: it is a note
};
std::string removal_line(std::uint64_t id);
/// nullopt: it can not be read.
std::optional<NoteLine> note_line(std::string_view line);

}  // namespace headframe
