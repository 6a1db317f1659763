#pragma once
// A loop over independent items on all cores.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace headframe::mine {

/// Calls body(i) once for each i < n, in any order and on several threads; body must not throw. Blocks until done.
template <class Body>
void for_each_index(std::size_t n, const Body& body) {
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < n; i = next++) body(i);
  };
  std::vector<std::jthread> others;
  for (unsigned k = 1; k < std::max(1U, std::thread::hardware_concurrency()) && k < n; ++k) others.emplace_back(work);
  work();
}

}  // namespace headframe::mine
