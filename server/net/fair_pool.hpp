#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace headframe {

/// Threads for work that peers cause. Owners take turns, one piece of work each, and none has two running at a time:
/// who causes much waits for itself. Holds what was submitted; whoever submits bounds that. Thread safe.
class FairPool {
 public:
  using Work = std::function<void()>;

  explicit FairPool(int threads);
  ~FairPool();  // finishes what runs and drops the rest
  FairPool(const FairPool&) = delete;
  FairPool& operator=(const FairPool&) = delete;

  /// `work` must not throw.
  void submit(const std::string& owner, Work work);

 private:
  void run();

  std::mutex mutex_;
  std::condition_variable wake_;
  std::map<std::string, std::deque<Work>> waiting_;  // of an owner whose work runs too, perhaps none
  std::deque<std::string> turns_;                    // of owners of whom nothing runs
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace headframe
