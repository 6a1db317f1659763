#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "server/station/station.hpp"

namespace headframe {

/// Carries out [store] keep = "newest": while less is free than the policy asks for, covered clouds go, the oldest
/// first, until half as much again is free. What went is in the log.
class RoomWatch {
 public:
  explicit RoomWatch(Station& station, std::chrono::milliseconds pause = std::chrono::seconds(10))
      : station_(station), pause_(pause) {}
  ~RoomWatch();  // ends what it waits for

  /// Looks again and again, on a thread of its own. Nothing, where all is kept.
  void start(const KeepPolicy& policy);

  /// Looks once: what went. Blocks on the disk.
  Result<std::vector<CoveredClouds>> look();

 private:
  Result<void> let_go(const std::vector<CoveredClouds>& clouds);
  void run();

  Station& station_;
  const std::chrono::milliseconds pause_;
  struct Bell {
    std::mutex mutex;
    std::condition_variable wake;
  };
  const std::shared_ptr<Bell> bell_ = std::make_shared<Bell>();  // the store may answer when the watch is gone
  bool stopping_ = false;
  bool said_ = false;  // that nothing may go
  std::thread thread_;
};

}  // namespace headframe
