#include "server/prepared_clouds.hpp"

namespace headframe {

std::shared_ptr<const PreparedCloud> PreparedClouds::get(const KeyframeRef& keyframe, CloudSource& source) {
  if (const auto known = entries_.find(keyframe); known != entries_.end()) {
    ages_.splice(ages_.begin(), ages_, known->second.age);
    return known->second.cloud;
  }
  if (source.state(keyframe) != CloudState::stored) return nullptr;
  const auto cloud = source.load(keyframe);
  if (!cloud) return nullptr;
  auto prepared = std::make_shared<const PreparedCloud>(prepare(*cloud, threads_));
  ages_.push_front(keyframe);
  entries_[keyframe] = {prepared, ages_.begin()};
  if (entries_.size() > capacity_) {
    entries_.erase(ages_.back());
    ages_.pop_back();
  }
  return prepared;
}

}  // namespace headframe
