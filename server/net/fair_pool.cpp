#include "server/net/fair_pool.hpp"

#include <sys/resource.h>
#include <unistd.h>

namespace headframe {
namespace {

constexpr int pool_nice = 10;  // as merging has: acks come first

}  // namespace

FairPool::FairPool(int threads) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { run(); });
}

FairPool::~FairPool() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void FairPool::submit(const std::string& owner, Work work) {
  {
    const std::lock_guard lock(mutex_);
    const auto [queue, fresh] = waiting_.try_emplace(owner);
    queue->second.push_back(std::move(work));
    if (fresh) turns_.push_back(owner);
  }
  wake_.notify_one();
}

void FairPool::run() {
  (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), pool_nice);  // harmless where it is refused
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [&] { return stopping_ || !turns_.empty(); });
    if (stopping_) return;
    const std::string owner = std::move(turns_.front());
    turns_.pop_front();
    Work work = std::move(waiting_.at(owner).front());
    waiting_.at(owner).pop_front();
    lock.unlock();
    work();
    work = nullptr;  // what it holds goes outside the lock
    lock.lock();
    if (waiting_.at(owner).empty()) {
      waiting_.erase(owner);
    } else {
      turns_.push_back(owner);
      wake_.notify_one();
    }
  }
}

}  // namespace headframe
