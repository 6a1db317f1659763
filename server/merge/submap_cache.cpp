#include "server/merge/submap_cache.hpp"

#include <algorithm>
#include <cmath>

#include "server/support/parallel.hpp"

namespace headframe {
namespace {

constexpr double step_m = 3;

std::size_t node_of(const SubmapRequest& r) {
  std::size_t node = r.keyframe;
  const double bin = std::floor(r.path_to_m[node] / step_m);
  while (node > 0 && std::floor(r.path_to_m[node - 1] / step_m) == bin) --node;
  return node;
}

/// The keyframes of a submap's window whose clouds are stored.
std::vector<const Keyframe*> window_of(const SubmapRequest& r, std::size_t node, const SubmapConfig& config,
                                       const CloudSource& source) {
  std::vector<const Keyframe*> out;
  const Eigen::Vector3d p = r.keyframes[node].T_local_sensor.translation();
  const auto first = std::lower_bound(r.path_to_m.begin(), r.path_to_m.end(), r.path_to_m[node] - config.window_m);
  for (auto at = first; at != r.path_to_m.end() && *at <= r.path_to_m[node] + config.window_m; ++at) {
    const Keyframe& k = r.keyframes[static_cast<std::size_t>(at - r.path_to_m.begin())];
    if (k.point_count == 0 || (k.T_local_sensor.translation() - p).norm() > config.farthest_m) continue;
    if (source.state({r.session, k.sequence}) == CloudState::stored) out.push_back(&k);
  }
  return out;
}

/// FNV-1a of their numbers.
std::uint64_t hash_of(const std::vector<const Keyframe*>& window) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const Keyframe* k : window) hash = (hash ^ k->sequence) * 1099511628211ULL;
  return hash;
}

}  // namespace

std::vector<SubmapPtr> SubmapCache::get(std::span<const SubmapRequest> requests, CloudSource& source) {
  std::map<Key, Build> missing;
  std::map<Key, SubmapPtr> answers;
  std::vector<Key> keys;
  keys.reserve(requests.size());
  for (const SubmapRequest& r : requests) {
    const Key key{r.session, node_of(r)};
    keys.push_back(key);
    if (answers.contains(key) || missing.contains(key)) continue;
    const auto window = window_of(r, key.keyframe, config_, source);
    if (const Entry* known = kept_.find(key); known && known->clouds == hash_of(window)) {
      answers[key] = known->submap;
      continue;
    }
    missing.emplace(key, Build{r.keyframes[key.keyframe].T_local_sensor.translation(), window, {}, nullptr});
  }
  fetch_clouds(missing, source);
  std::vector<Build*> builds;
  builds.reserve(missing.size());
  for (auto& [key, build] : missing) builds.push_back(&build);
  for_blocks(builds.size(), 1, threads_, [&](std::size_t i, std::size_t, std::size_t) {
    builds[i]->submap = std::make_shared<const Submap>(make_submap(builds[i]->clouds, builds[i]->p, config_));
  });
  for (const auto& [key, build] : missing) {
    answers[key] = build.submap;
    keep(key, build.submap, hash_of(build.window));
  }
  std::vector<SubmapPtr> out;
  out.reserve(keys.size());
  for (const Key& key : keys) out.push_back(answers.at(key));
  return out;
}

/// Loads each cloud once, however many submaps use it.
void SubmapCache::fetch_clouds(std::map<Key, Build>& builds, CloudSource& source) {
  std::map<KeyframeRef, std::shared_ptr<const PreparedCloud>> clouds;
  for (const auto& [key, build] : builds)
    for (const Keyframe* k : build.window) clouds[{key.session, k->sequence}];
  std::vector<KeyframeRef> asked;
  asked.reserve(clouds.size());
  for (const auto& [keyframe, cloud] : clouds) asked.push_back(keyframe);
  const auto prepared = prepared_.get(asked, source);
  for (std::size_t i = 0; i < asked.size(); ++i) clouds[asked[i]] = prepared[i];
  for (auto& [key, build] : builds)
    for (const Keyframe* k : build.window)
      if (const auto& cloud = clouds.at({key.session, k->sequence}))
        build.clouds.push_back({k->sequence, k->T_local_sensor, cloud, k->stamp_s});
}

void SubmapCache::keep(const Key& key, SubmapPtr submap, std::uint64_t clouds) {
  if (kept_.find(key)) let_go(*kept_.drop(key).submap);
  bytes_ += bytes_of(*submap);
  for (const PlacedView& view : submap->views)
    if (looked_from_[view.image.get()]++ == 0) bytes_ += view.image->bytes();
  kept_.put(key, {std::move(submap), clouds});
  while (bytes_ > capacity_bytes_ && kept_.size() > 1) let_go(*kept_.drop_oldest().submap);
}

void SubmapCache::forget(SessionId session) {
  std::vector<Key> gone;
  kept_.each_key([&](const Key& key) {
    if (key.session == session) gone.push_back(key);
  });
  for (const Key& key : gone) let_go(*kept_.drop(key).submap);
}

void SubmapCache::let_go(const Submap& submap) {
  bytes_ -= bytes_of(submap);
  for (const PlacedView& view : submap.views) {
    const auto image = looked_from_.find(view.image.get());
    if (--image->second > 0) continue;
    bytes_ -= view.image->bytes();
    looked_from_.erase(image);
  }
}

}  // namespace headframe
