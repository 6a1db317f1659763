#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace headframe {

/// While one lives the process is on its way out: after so long it ends at once, with this status, whatever its threads
/// do. Nothing that was acknowledged is lost by that, for it is on disk; robots repeat the rest, and attempts to merge
/// are made anew after the next start.
class StopDeadline {
 public:
  explicit StopDeadline(std::chrono::milliseconds after, int status = 0);
  ~StopDeadline();  // it is done in time
  StopDeadline(const StopDeadline&) = delete;
  StopDeadline& operator=(const StopDeadline&) = delete;

 private:
  std::mutex mutex_;
  std::condition_variable wake_;
  bool done_ = false;
  std::thread thread_;
};

}  // namespace headframe
