#include "server/merge/cloud_cache.hpp"

namespace headframe {

std::shared_ptr<const PreparedCloud> CloudCache::get(const KeyframeRef& keyframe, CloudSource& source) {
  if (const auto* known = kept_.find(keyframe)) return *known;
  if (source.state(keyframe) != CloudState::stored) return nullptr;
  const auto cloud = source.load(keyframe);
  if (!cloud) return nullptr;
  auto prepared = std::make_shared<const PreparedCloud>(prepare(*cloud, threads_));
  kept_.put(keyframe, prepared);
  bytes_ += bytes_of(*prepared);
  while (bytes_ > capacity_bytes_ && kept_.size() > 1) bytes_ -= bytes_of(*kept_.drop_oldest());
  return prepared;
}

}  // namespace headframe
