#pragma once

#include <algorithm>
#include <cstddef>
#include <thread>
#include <vector>

namespace headframe {

/// Calls work(begin, end, block) for fixed blocks of `block_size` items, spread over threads. The blocks do not depend
/// on the number of threads: sums kept by block and added in order are the same for any.
template <class Work>
void for_blocks(std::size_t items, std::size_t block_size, int threads, Work&& work) {
  const std::size_t blocks = (items + block_size - 1) / block_size;
  const auto stride = static_cast<std::size_t>(std::max(1, threads));
  const auto run = [&](std::size_t first) {
    for (std::size_t b = first; b < blocks; b += stride) work(b * block_size, std::min(items, (b + 1) * block_size), b);
  };
  std::vector<std::jthread> helpers;
  for (std::size_t t = 1; t < std::min(stride, blocks); ++t) helpers.emplace_back(run, t);
  run(0);
}

}  // namespace headframe
