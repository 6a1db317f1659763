#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "server/merge/cloud_source.hpp"
#include "server/support/lru_map.hpp"
#include "server/verification/prepared_cloud.hpp"

namespace headframe {

/// Clouds of keyframes, prepared once and kept while they fit: the least recently used go first, the latest stays
/// however large. Not thread safe.
class CloudCache {
 public:
  CloudCache(std::size_t capacity_bytes, int threads) : capacity_bytes_(capacity_bytes), threads_(threads) {}

  /// Null when the cloud is not stored, or can not be read.
  std::shared_ptr<const PreparedCloud> get(const KeyframeRef& keyframe, CloudSource& source);
  /// The same of several, in order; those that are missing are prepared side by side. None may be asked for twice.
  std::vector<std::shared_ptr<const PreparedCloud>> get(std::span<const KeyframeRef> keyframes, CloudSource& source);

 private:
  void keep(const KeyframeRef& keyframe, std::shared_ptr<const PreparedCloud> cloud);

  std::size_t capacity_bytes_;
  int threads_;
  std::size_t bytes_ = 0;
  LruMap<KeyframeRef, std::shared_ptr<const PreparedCloud>> kept_;
};

}  // namespace headframe
