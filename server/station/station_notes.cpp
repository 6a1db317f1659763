#include "server/station/station_notes.hpp"

#include <algorithm>

#include "common/wire/limits.hpp"

namespace headframe {

Result<void> StationNotes::restore() {
  auto notes = store_.notes();
  if (!notes) return tl::unexpected(notes.error());
  const std::lock_guard lock(mutex_);
  labels_ = std::move(notes->labels);
  surveys_ = std::move(notes->surveys);
  session_notes_ = std::move(notes->notes);
  return {};
}

std::map<SessionId, std::string> StationNotes::labels() const {
  const std::lock_guard lock(mutex_);
  return labels_;
}

std::map<SessionId, std::string> StationNotes::notes() const {
  const std::lock_guard lock(mutex_);
  return session_notes_;
}

std::vector<Survey> StationNotes::surveys() const {
  const std::lock_guard lock(mutex_);
  return surveys_;
}

void StationNotes::rename(SessionId session, const std::string& label, Done done) {
  const bool readable = std::none_of(label.begin(), label.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
  if (label.size() > limits::name_bytes || !readable)
    return done(failure(ErrorCode::invalid_argument,
                        "a label is one line of at most " + std::to_string(limits::name_bytes) + " bytes"));
  write(
      PutLabel{session, label}, [this, session, label] { labels_[session] = label; }, std::move(done));
}

void StationNotes::note(SessionId session, const std::string& note, Done done) {
  const bool readable =
      std::none_of(note.begin(), note.end(), [](unsigned char c) { return (c < 0x20 && c != '\n') || c == 0x7f; });
  if (note.size() > most_note_bytes || !readable)
    return done(failure(ErrorCode::invalid_argument,
                        "a note is text of at most " + std::to_string(most_note_bytes) + " bytes"));
  write(
      PutSessionNote{session, note}, [this, session, note] { session_notes_[session] = note; }, std::move(done));
}

void StationNotes::set_survey(const Survey& survey, Done done) {
  write(
      PutSurvey{survey},
      [this, survey] {
        std::erase_if(surveys_, [&](const Survey& other) { return other.session == survey.session; });
        surveys_.push_back(survey);
      },
      std::move(done));
}

void StationNotes::drop_survey(SessionId session, Done done) {
  {
    std::unique_lock lock(mutex_);
    if (std::none_of(surveys_.begin(), surveys_.end(), [&](const Survey& s) { return s.session == session; })) {
      lock.unlock();
      return done(failure(ErrorCode::not_found, "session " + std::to_string(session) + " has no survey"));
    }
  }
  write(
      DropSurvey{session},
      [this, session] { std::erase_if(surveys_, [&](const Survey& other) { return other.session == session; }); },
      std::move(done));
}

/// Writes become durable in the order of the calls, so what is visible here is what a restart finds.
void StationNotes::write(Write write, std::function<void()> apply, Done done) {
  store_.write(std::move(write), [this, apply = std::move(apply), done = std::move(done)](const Result<void>& durable) {
    if (durable) {
      const std::lock_guard lock(mutex_);
      apply();
    }
    done(durable);
  });
}

}  // namespace headframe
