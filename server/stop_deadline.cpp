#include "server/stop_deadline.hpp"

#include <cstdlib>
#include <iostream>

#include "server/merge_worker/work_mark.hpp"

namespace headframe {

StopDeadline::StopDeadline(std::chrono::milliseconds after, int status) {
  thread_ = std::thread([this, after, status] {
    std::unique_lock lock(mutex_);
    if (wake_.wait_for(lock, after, [this] { return done_; })) return;
    std::cerr << "headframe-server: not finished in time, ending all the same; what was acknowledged is on disk\n";
    WorkMark::died();  // what it worked on held it up
    std::_Exit(status);
  });
}

StopDeadline::~StopDeadline() {
  {
    const std::lock_guard lock(mutex_);
    done_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

}  // namespace headframe
