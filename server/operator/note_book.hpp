#pragma once
// What operators wrote on the map: notes and measurements that others see, kept over restarts.

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

/// A place of a session's map, in the session's own frame (m): it stays where it is when maps move.
struct NotePlace {
  SessionId session = 0;
  std::array<double, 3> p_session{};
};

struct Note {
  std::string kind;  // note, distance, line, area
  std::string text;  // UTF-8, may be empty but of a note
  std::vector<NotePlace> places;
  std::string by;        // the operator's name; empty: who has the server's own token
  std::uint64_t id = 0;  // counts up from 1; the book gives it
  double at_s = 0;       // since the epoch; the book gives it
};

struct NoteLimits {
  std::size_t notes = 1000;
  std::size_t text_bytes = 500;
  std::size_t places = 100;  // of a note
};

/// A file of JSON objects, one a line: notes, and the ids of those that were taken away. What add() and remove() return
/// well is on the disk; they wait for it, so that no I/O thread may call them. A line that cannot be read is left out.
/// Thread safe.
class NoteBook {
 public:
  /// An empty path: memory alone.
  explicit NoteBook(std::filesystem::path file = {}, const NoteLimits& limits = {});
  ~NoteBook();
  NoteBook(const NoteBook&) = delete;
  NoteBook& operator=(const NoteBook&) = delete;

  /// By their ids.
  std::vector<Note> notes() const;
  /// With its id and time. invalid_argument: of an unknown kind, with too few or too many places or one that is not
  /// finite, too long; refused: there are too many notes; unavailable: the disk.
  Result<Note> add(Note note);
  /// What it was. not_found; unavailable: the disk.
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
  std::size_t lines_ = 0;  // of the file
  int descriptor_ = -1;
};

}  // namespace headframe
