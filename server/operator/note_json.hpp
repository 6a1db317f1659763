#pragma once
// Notes as JSON: in responses, in requests, and in the file that keeps them. All functions are pure.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/operator/note_book.hpp"

namespace headframe {

/// {"id", "kind", "text", "by", "at_s", "places": [{"session_id", "p_session"}]}, on one line.
std::string note_json(const Note& note);
/// {"notes": [...]}
std::string notes_json(const std::vector<Note>& notes);
/// Reads {"kind", "text", "places"}. bad_input: the message says what is wrong. Only the form is checked; NoteBook
/// checks the content.
Result<Note> note_from_json(std::string_view body);

/// A line of the file: a note, or the id of one that was removed.
struct NoteLine {
  Note note;
  std::uint64_t removed = 0;  // 0: the line holds a note
};
std::string removal_line(std::uint64_t id);
/// nullopt: the line cannot be read.
std::optional<NoteLine> note_line(std::string_view line);

}  // namespace headframe
