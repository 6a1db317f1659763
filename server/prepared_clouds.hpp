#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <memory>

#include "server/merge_pipeline.hpp"
#include "server/registration/submap.hpp"

namespace headframe {

/// Clouds of keyframes, prepared once and kept while there is room: the least recently used go first. Not thread safe.
class PreparedClouds {
 public:
  PreparedClouds(std::size_t capacity, int threads) : capacity_(capacity), threads_(threads) {}

  /// Null when the cloud is not stored, or can not be read.
  std::shared_ptr<const PreparedCloud> get(const KeyframeRef& keyframe, CloudSource& source);

 private:
  struct Entry {
    std::shared_ptr<const PreparedCloud> cloud;
    std::list<KeyframeRef>::iterator age;
  };
  std::size_t capacity_;
  int threads_;
  std::map<KeyframeRef, Entry> entries_;
  std::list<KeyframeRef> ages_;  // most recently used first
};

}  // namespace headframe
