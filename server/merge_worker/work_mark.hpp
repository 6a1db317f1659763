#pragma once

#include <filesystem>
#include <utility>

#include "common/result.hpp"
#include "server/session/ids.hpp"

namespace headframe {

/// Remembers beyond the end of the process which sessions it worked on: a file of a few bytes, not synced, for what was
/// written stays when a process dies (after a power cut it may not: then nobody is blamed). One thread uses it, but for
/// died().
class WorkMark {
 public:
  enum class End {
    well,    // it worked on nothing
    killed,  // from outside, or for want of memory
    died,    // of what it did
  };
  struct Left {
    SessionId a = 0, b = 0;  // the same where it worked on one alone
    End end = End::well;
  };

  /// Takes what the process before left in the file, and begins anew. unavailable: the file can not be written.
  static Result<WorkMark> open(const std::filesystem::path& file);
  WorkMark(WorkMark&& other) noexcept;
  WorkMark& operator=(WorkMark&&) = delete;
  ~WorkMark();

  const Left& left() const { return left_; }
  void on(SessionId a, SessionId b) { write({a, b, End::killed}); }
  void off() { write({}); }

  /// This process ends by what it is doing now. Safe in a signal handler; speaks for the mark that was opened last.
  static void died();
  /// From here on the signals of a fault call died() before they end the process as they would have.
  static void watch_for_faults();

 private:
  WorkMark(int file, const Left& left) : file_(file), left_(left) {}
  void write(const Left& now) const;

  int file_ = -1;
  Left left_;
};

}  // namespace headframe
