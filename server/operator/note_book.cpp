#include "server/operator/note_book.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "server/operator/note_json.hpp"

namespace headframe {
namespace {

constexpr std::size_t lines_for_a_note = 4;  // lines per permitted note, beyond which the file is rewritten
constexpr double farthest_m = 1e7;

double clock_s() { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count(); }

bool write_whole(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

/// The minimum number of places for a note of this kind; 0: there is no such kind.
std::size_t least_places(const std::string& kind) {
  static const std::map<std::string, std::size_t> kinds{{"note", 1}, {"distance", 2}, {"line", 2}, {"area", 3}};
  const auto found = kinds.find(kind);
  return found == kinds.end() ? 0 : found->second;
}

}  // namespace

NoteBook::NoteBook(std::filesystem::path file, const NoteLimits& limits) : file_(std::move(file)), limits_(limits) {
  if (file_.empty()) return;
  read();
  if (!begin_anew()) descriptor_ = ::open(file_.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
}

NoteBook::~NoteBook() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void NoteBook::read() {
  std::ifstream in(file_, std::ios::binary);
  for (std::string line; std::getline(in, line);) {
    const auto entry = note_line(line);
    if (!entry) continue;
    newest_ = std::max({newest_, entry->note.id, entry->removed});
    if (entry->removed != 0)
      notes_.erase(entry->removed);
    else if (check(entry->note))
      notes_[entry->note.id] = entry->note;
  }
}

/// Rewrites the file without removed notes. The old file stays until the new one is on the disk. The newest id is kept
/// in it, so that no id is given twice. Call with the lock held, or in the constructor.
bool NoteBook::begin_anew() {
  std::string all = removal_line(newest_);
  for (const auto& [id, note] : notes_) all += note_json(note);
  const std::filesystem::path part = file_.string() + ".part";
  const int made = ::open(part.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  std::error_code fault;
  bool done = made >= 0 && write_whole(made, all) && ::fdatasync(made) == 0;
  if (done) std::filesystem::rename(part, file_, fault);
  done = done && !fault;
  if (!done) {
    if (made >= 0) ::close(made);
    return false;
  }
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = made;
  lines_ = notes_.size() + 1;
  return true;
}

std::vector<Note> NoteBook::notes() const {
  const std::lock_guard lock(mutex_);
  std::vector<Note> all;
  all.reserve(notes_.size());
  for (const auto& [id, note] : notes_) all.push_back(note);
  return all;
}

Result<void> NoteBook::check(const Note& note) const {
  const auto wrong = [](const std::string& what) { return failure(ErrorCode::invalid_argument, "the note: " + what); };
  const std::size_t least = least_places(note.kind);
  if (least == 0) return wrong("\"" + note.kind + "\" is no kind; there are note, distance, line and area");
  if (note.places.size() < least || note.places.size() > limits_.places)
    return wrong("it has " + std::to_string(note.places.size()) + " places; give " + std::to_string(least) + " to " +
                 std::to_string(limits_.places));
  if (note.text.size() > limits_.text_bytes)
    return wrong("its text is longer than " + std::to_string(limits_.text_bytes) + " bytes");
  if (note.kind == "note" && note.text.empty()) return wrong("it says nothing");
  for (const NotePlace& place : note.places)
    for (const double value : place.p_session)
      if (!std::isfinite(value) || std::abs(value) > farthest_m) return wrong("a place of it is nowhere in a mine");
  return {};
}

/// Appends a line. After a failure the file is as before, so that a refused note does not reappear. Call with the lock
/// held.
Result<void> NoteBook::write(const std::string& line) {
  if (file_.empty()) return {};
  const off_t before = descriptor_ < 0 ? -1 : ::lseek(descriptor_, 0, SEEK_END);
  if (before >= 0 && write_whole(descriptor_, line) && ::fdatasync(descriptor_) == 0) {
    ++lines_;
    return {};
  }
  if (before >= 0) (void)!::ftruncate(descriptor_, before);
  return failure(ErrorCode::unavailable, file_.string() + " can not be written; is the disk full?");
}

Result<Note> NoteBook::add(Note note) {
  const std::lock_guard lock(mutex_);
  if (auto fine = check(note); !fine) return tl::unexpected(fine.error());
  if (notes_.size() >= limits_.notes)
    return failure(ErrorCode::refused,
                   "there are " + std::to_string(limits_.notes) + " notes already; take some of them away first");
  note.id = newest_ + 1;
  note.at_s = clock_s();
  if (auto written = write(note_json(note)); !written) return tl::unexpected(written.error());
  newest_ = note.id;
  notes_[note.id] = note;
  return note;
}

Result<Note> NoteBook::remove(std::uint64_t id) {
  const std::lock_guard lock(mutex_);
  const auto found = notes_.find(id);
  if (found == notes_.end()) return failure(ErrorCode::not_found, "there is no note " + std::to_string(id));
  if (auto written = write(removal_line(id)); !written) return tl::unexpected(written.error());
  Note gone = std::move(found->second);
  notes_.erase(found);
  if (lines_ > lines_for_a_note * limits_.notes) begin_anew();
  return gone;
}

}  // namespace headframe
