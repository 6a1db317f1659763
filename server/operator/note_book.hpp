#pragma once
// Notes and measurements that operators made on the map. All operators see them; they are kept across restarts.

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "server/session/ids.hpp"

namespace headframe {

/// A position in a session's own frame (m), so that it moves along with the session's map.
struct NotePlace {
  SessionId session = 0;
  std::array<double, 3> p_session{};
};

struct Note {
  std::string kind;  // note, distance, line, area
  std::string text;  // UTF-8; may be empty unless kind is "note"
  std::vector<NotePlace> places;
  std::string by;        // the operator's name; empty: one with the server's own token
  std::uint64_t id = 0;  // increases from 1; set by the book
  double at_s = 0;       // since the epoch; set by the book
};

struct NoteLimits {
  std::size_t notes = 1000;
  std::size_t text_bytes = 500;
  std::size_t places = 100;  // per note
};

/// Notes in a file of JSON objects, one per line: notes, and the ids of those that were removed. When add() and
/// remove() succeed, the change is on the disk; they wait for it, so do not call them on an I/O thread. A line that
/// cannot be read is skipped. Thread safe.
class NoteBook {
 public:
  /// With an empty path, notes are kept only in memory.
  explicit NoteBook(std::filesystem::path file = {}, const NoteLimits& limits = {});
  ~NoteBook();
  NoteBook(const NoteBook&) = delete;
  NoteBook& operator=(const NoteBook&) = delete;

  /// Ordered by id.
  std::vector<Note> notes() const;
  /// Returns the note with its id and time. invalid_argument: an unknown kind, too few or too many places, a place that
  /// is not finite or beyond any mine, a text that is too long, or none for a "note"; refused: there are too many
  /// notes; unavailable: the disk failed.
  Result<Note> add(Note note);
  /// Returns the removed note. not_found: there is none with this id; unavailable: the disk failed.
  Result<Note> remove(std::uint64_t id);

 private:
  void read();
  Result<void> check(const Note& note) const;
  Result<void> write(const std::string& line);
  bool begin_anew();

  const std::filesystem::path file_;
  const NoteLimits limits_;
  mutable std::mutex mutex_;
  std::map<std::uint64_t, Note> notes_;
  std::uint64_t newest_ = 0;
  std::size_t lines_ = 0;  // in the file
  int descriptor_ = -1;
};

}  // namespace headframe
