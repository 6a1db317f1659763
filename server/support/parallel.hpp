#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>

namespace headframe {

/// Calls call(work, block) once for each of the blocks 0 .. blocks - 1, on the calling thread and at most threads - 1
/// helpers from a pool that lives as long as the program. The caller takes part and never waits for a free helper, so
/// calls may be nested and made from many threads at once. The first exception thrown by a block is rethrown after all
/// blocks in progress have ended.
void share_blocks(std::size_t blocks, int threads, void* work, void (*call)(void* work, std::size_t block));

/// While such an object exists, for_blocks on its thread throws Cancelled before the next block once the flag is set,
/// which ends work whose result is no longer wanted. The flag must outlive the object. Not nestable.
class Cancellable {
 public:
  explicit Cancellable(const std::atomic<bool>& flag);
  ~Cancellable();
  Cancellable(const Cancellable&) = delete;
  Cancellable& operator=(const Cancellable&) = delete;

  static const std::atomic<bool>* flag();  // of this thread; null if there is none
};

class Cancelled : public std::exception {
 public:
  const char* what() const noexcept override { return "cancelled"; }
};

/// Calls work(begin, end, block) for fixed blocks of `block_size` items, distributed over threads. The blocks do not
/// depend on the number of threads, so sums that are kept for each block and added in order do not either. Throws what
/// the work throws, and Cancelled.
template <class Work>
void for_blocks(std::size_t items, std::size_t block_size, int threads, Work&& work) {
  const std::size_t blocks = (items + block_size - 1) / block_size;
  const std::atomic<bool>* const cancelled = Cancellable::flag();
  auto one = [&](std::size_t b) {
    if (cancelled && *cancelled) throw Cancelled();
    work(b * block_size, std::min(items, (b + 1) * block_size), b);
  };
  if (threads <= 1 || blocks <= 1) {
    for (std::size_t b = 0; b < blocks; ++b) one(b);
    return;
  }
  share_blocks(blocks, threads, &one, [](void* w, std::size_t b) { (*static_cast<decltype(one)*>(w))(b); });
}

}  // namespace headframe
