#pragma once
// A log of what happened at the station and what operators did, kept across restarts.

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
  std::string kind;           // started, connected, left, finished, jumped, let_go, merged, withdrawn, held_back,
                              // provisional, unsure, no_match, revision, operator, note
  std::string text;           // one line for humans; sessions are named "robot/session"
  SessionId session = 0;      // the session concerned; 0: none
  AlignmentId alignment = 0;  // the alignment concerned; 0: none
  std::string by = {};        // the operator's name; empty: no operator did it, or one with the server's own token
  std::uint64_t id = 0;       // increases from 1; set by the log
  double at_s = 0;            // since the epoch; set by the log
};

struct EventLogLimits {
  std::size_t entries = 1000;         // kept in memory; older ones are only in the file
  std::size_t file_bytes = 4U << 20;  // beyond this size the file is rewritten with the entries in memory
};

/// Appends entries to a file, one JSON object per line. A line that cannot be read is skipped. An entry that cannot be
/// written is kept only in memory. Thread safe. An entry that was written survives a crash of the process, but not
/// necessarily one of the machine.
class EventLog {
 public:
  /// With an empty path, entries are kept only in memory.
  explicit EventLog(std::filesystem::path file = {}, const EventLogLimits& limits = {});

  void add(LogEntry entry);
  /// The latest entries, at most so many; the newest is last.
  std::vector<LogEntry> latest(std::size_t most) const;
  /// The entries after the one with this id, as far as they are in memory.
  std::vector<LogEntry> since(std::uint64_t id) const;
  /// The id of the newest entry; 0: there is none.
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

/// {"entries": [...]}; the newest is last.
std::string log_json(const std::vector<LogEntry>& entries);
/// {"type": "log", "entry": {...}}
std::string log_event(const LogEntry& entry);

}  // namespace headframe
