#include "server/support/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

namespace headframe {
namespace {

/// For so long a thread looks for work before it sleeps. With 50 us one more session among 1000 settles 2 to 6 % sooner
/// (./run bench years); 200 us gain no more.
constexpr std::chrono::microseconds spin_time{50};

struct Job {
  std::size_t blocks = 0;
  void* work = nullptr;
  void (*call)(void*, std::size_t) = nullptr;
  std::atomic<std::size_t> next{0};
  // The members below are changed only under the pool's mutex.
  std::atomic<int> helpers_inside{0};
  int helpers_wanted = 0;
  std::exception_ptr failure;
};

class Pool {
 public:
  Pool() {
    const unsigned count = std::max(4U, std::thread::hardware_concurrency()) - 1;
    threads_.reserve(count);
    for (unsigned i = 0; i < count; ++i) threads_.emplace_back([this](const std::stop_token& stop) { help(stop); });
  }

  void run(Job& job, int helpers) {
    int asleep = helpers;
    {
      const std::lock_guard lock(mutex_);
      asleep -= std::max(0, looking_ - static_cast<int>(open_.size()));  // the jobs before this one come first
      job.helpers_wanted = helpers;
      open_.push_back(&job);
      jobs_ = open_.size();
    }
    for (int i = 0; i < asleep; ++i) came_.notify_one();
    drain(job);
    std::unique_lock lock(mutex_);
    std::erase(open_, &job);
    jobs_ = open_.size();
    if (job.helpers_inside > 0) {
      lock.unlock();
      look_for([&] { return job.helpers_inside == 0; });
      lock.lock();
    }
    left_.wait(lock, [&] { return job.helpers_inside == 0; });
    if (job.failure) std::rethrow_exception(job.failure);
  }

 private:
  void drain(Job& job) {
    try {
      for (std::size_t b = job.next++; b < job.blocks; b = job.next++) job.call(job.work, b);
    } catch (...) {
      job.next = job.blocks;
      const std::lock_guard lock(mutex_);
      if (!job.failure) job.failure = std::current_exception();
    }
  }

  void help(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (came_.wait(lock, stop, [&] { return !open_.empty(); })) {
      Job& job = *open_.front();
      if (--job.helpers_wanted == 0) open_.pop_front();
      jobs_ = open_.size();
      ++job.helpers_inside;
      lock.unlock();
      drain(job);
      lock.lock();
      if (--job.helpers_inside == 0) left_.notify_all();
      if (!open_.empty()) continue;
      ++looking_;
      lock.unlock();
      look_for([this] { return jobs_ > 0; });
      lock.lock();
      --looking_;
    }
  }

  /// Returns once the condition holds, or after spin_time.
  template <class Condition>
  static void look_for(Condition condition) {
    const auto until = std::chrono::steady_clock::now() + spin_time;
    while (!condition() && std::chrono::steady_clock::now() < until) std::this_thread::yield();
  }

  std::mutex mutex_;
  std::condition_variable_any came_;
  std::condition_variable left_;
  std::deque<Job*> open_;
  std::atomic<std::size_t> jobs_{0};   // in open_
  int looking_ = 0;                    // helpers that will see a new job without being woken
  std::vector<std::jthread> threads_;  // last, so that they are joined before what they use is destroyed
};

}  // namespace

namespace {
thread_local const std::atomic<bool>* flag_here = nullptr;
}  // namespace

Cancellable::Cancellable(const std::atomic<bool>& flag) { flag_here = &flag; }
Cancellable::~Cancellable() { flag_here = nullptr; }
const std::atomic<bool>* Cancellable::flag() { return flag_here; }

void share_blocks(std::size_t blocks, int threads, void* work, void (*call)(void*, std::size_t)) {
  static Pool pool;
  Job job;
  job.blocks = blocks;
  job.work = work;
  job.call = call;
  pool.run(job, static_cast<int>(std::min(blocks, static_cast<std::size_t>(threads))) - 1);
}

}  // namespace headframe
