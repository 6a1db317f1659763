#pragma once
// The operator's labels, notes and surveys of sessions. They are stored first, then take effect.

#include <functional>
#include <map>
#include <mutex>

#include "server/store/store.hpp"

namespace headframe {

/// Thread safe. Callbacks run once, on the store's thread, when the change is durable and visible here, or with the
/// failure.
class StationNotes {
 public:
  using Done = std::function<void(const Result<void>&)>;

  explicit StationNotes(Store& store) : store_(store) {}

  Result<void> restore();

  std::map<SessionId, std::string> labels() const;
  std::map<SessionId, std::string> notes() const;
  /// In the order in which they were set.
  std::vector<Survey> surveys() const;

  /// An empty label removes it. invalid_argument: longer than 128 bytes, or with control characters.
  void rename(SessionId session, const std::string& label, Done done);
  /// An empty note removes it. invalid_argument: longer than most_note_bytes, or with control characters other than
  /// line breaks.
  void note(SessionId session, const std::string& note, Done done);
  static constexpr std::size_t most_note_bytes = 2000;
  void set_survey(const Survey& survey, Done done);
  /// not_found: the session has none.
  void drop_survey(SessionId session, Done done);

 private:
  void write(Write write, std::function<void()> apply, Done done);

  Store& store_;
  mutable std::mutex mutex_;
  std::map<SessionId, std::string> labels_, session_notes_;
  std::vector<Survey> surveys_;
};

}  // namespace headframe
