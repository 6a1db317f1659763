#pragma once

#include <filesystem>
#include <utility>

#include "common/result.hpp"
#include "server/session/ids.hpp"

namespace headframe {

/// Records in a file which sessions are being worked on, so that the next process knows if this one dies. The file has
/// a few bytes and is not synced: it survives the process, but perhaps not a power cut (then no session is blamed). For
/// one thread only, except died().
class WorkMark {
 public:
  enum class End {
    well,    // it worked on nothing
    killed,  // from outside, or because memory ran out
    died,    // of a fault in what it did
  };
  struct Left {
    SessionId a = 0, b = 0;  // equal if it worked on a single session
    End end = End::well;
  };

  /// Reads what the last process left in the file, and starts afresh. unavailable: the file cannot be written.
  static Result<WorkMark> open(const std::filesystem::path& file);
  WorkMark(WorkMark&& other) noexcept;
  WorkMark& operator=(WorkMark&&) = delete;
  ~WorkMark();

  const Left& left() const { return left_; }
  void on(SessionId a, SessionId b) { write({a, b, End::killed}); }
  void off() { write({}); }

  /// Records that this process is dying of what it does now. Safe in a signal handler; applies to the mark opened last.
  static void died();
  /// From now on the signals of a fault call died() before they end the process as usual.
  static void watch_for_faults();

 private:
  WorkMark(int file, const Left& left) : file_(file), left_(left) {}
  void write(const Left& now) const;

  int file_ = -1;
  Left left_;
};

}  // namespace headframe
