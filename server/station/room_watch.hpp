#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "server/station/station.hpp"

namespace headframe {

/// Implements [store] keep = "newest": while less space is free than the policy demands, deletes covered clouds, oldest
/// first, until half as much again is free. Deletions are logged.
class RoomWatch {
 public:
  explicit RoomWatch(Station& station, std::chrono::milliseconds pause = std::chrono::seconds(10))
      : station_(station), pause_(pause) {}
  ~RoomWatch();  // ends the waiting

  /// Checks repeatedly, on its own thread. Does nothing if the policy keeps everything.
  void start(const KeepPolicy& policy);

  /// Checks once and returns what was deleted. Blocks on the disk.
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
  const std::shared_ptr<Bell> bell_ = std::make_shared<Bell>();  // shared: the store may answer when the watch is gone
  bool stopping_ = false;
  bool said_ = false;  // that nothing may be deleted was logged
  std::thread thread_;
};

}  // namespace headframe
