#pragma once
// What happened at the station and what operators did, kept over restarts.

#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "server/atlas/alignment.hpp"

namespace headframe {

struct LogEntry {
  std::string kind;       // started, connected, left, finished, let_go, merged, withdrawn, held_back, unsure, no_match,
                          // revision, operator, note
  std::string text;       // one line for people; sessions are named "robot/session"
  SessionId session = 0;  // what it is about; 0: no session
  AlignmentId alignment = 0;  // 0: no alignment
  std::string by = {};        // the operator's name; empty: nobody did it, or who shows the server's own token
  std::uint64_t id = 0;       // counts up from 1; the log gives it
  double at_s = 0;            // since the epoch; the log gives it
};

struct EventLogLimits {
  std::size_t entries = 1000;         // kept at hand; older ones are in the file alone
  std::size_t file_bytes = 4U << 20;  // beyond it the file begins anew with the entries at hand
};

/// Entries are appended to a file, a JSON object a line. A line that cannot be read is left out; a file that cannot be
/// written leaves the log in memory alone. Thread safe; an entry that was added is in the file unless the machine
/// fails.
class EventLog {
 public:
  /// An empty path: memory alone.
  explicit EventLog(std::filesystem::path file = {}, const EventLogLimits& limits = {});

  void add(LogEntry entry);
  /// The newest last, at most so many.
  std::vector<LogEntry> latest(std::size_t most) const;
  /// Those that came after the one with this id, as far as they are at hand.
  std::vector<LogEntry> since(std::uint64_t id) const;
  /// Of the newest entry; 0: there is none.
  std::uint64_t newest() const;

 private:
  void read();
  void begin_anew();

  const std::filesystem::path file_;
  const EventLogLimits limits_;
  mutable std::mutex mutex_;
  std::deque<LogEntry> entries_;
  std::uint64_t newest_ = 0;
  std::ofstream out_;
  std::size_t written_bytes_ = 0;
};

/// {"entries": [...]}, the newest last.
std::string log_json(const std::vector<LogEntry>& entries);
/// {"type": "log", "entry": {...}}
std::string log_event(const LogEntry& entry);

}  // namespace headframe
