#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "server/merge/cloud_source.hpp"
#include "server/support/lru_map.hpp"
#include "server/verification/prepared_cloud.hpp"

namespace headframe {

/// Prepared clouds of keyframes, kept within a memory limit: the least recently used are discarded first; the latest is
/// kept however large it is. Not thread safe.
class CloudCache {
 public:
  CloudCache(std::size_t capacity_bytes, int threads) : capacity_bytes_(capacity_bytes), threads_(threads) {}

  /// Null if the cloud is not stored or cannot be read.
  std::shared_ptr<const PreparedCloud> get(const KeyframeRef& keyframe, CloudSource& source);
  /// The same for several keyframes, in order; missing clouds are prepared in parallel. No keyframe may occur twice.
  std::vector<std::shared_ptr<const PreparedCloud>> get(std::span<const KeyframeRef> keyframes, CloudSource& source);

 private:
  void keep(const KeyframeRef& keyframe, std::shared_ptr<const PreparedCloud> cloud);

  std::size_t capacity_bytes_;
  int threads_;
  std::size_t bytes_ = 0;
  LruMap<KeyframeRef, std::shared_ptr<const PreparedCloud>> kept_;
};

}  // namespace headframe
