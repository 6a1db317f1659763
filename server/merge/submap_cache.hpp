#pragma once

#include <map>
#include <span>

#include "common/session/keyframe.hpp"
#include "server/merge/cloud_cache.hpp"
#include "server/verification/submap.hpp"

namespace headframe {

/// A session's path, and the keyframe around which the submap is wanted.
struct SubmapRequest {
  SessionId session = 0;
  std::span<const Keyframe> keyframes;
  std::span<const double> path_to_m;  // length of the path to each keyframe
  std::size_t keyframe = 0;
};

/// The submaps of sessions, one for every 3 m of path. They are built when first needed, rebuilt when the set of their
/// stored clouds has changed, and kept within a memory limit together with the sight images they use; the least
/// recently used are discarded first. Not thread safe.
class SubmapCache {
 public:
  SubmapCache(std::size_t capacity_bytes, int threads, const SubmapConfig& config, CloudCache& prepared)
      : capacity_bytes_(capacity_bytes), threads_(threads), config_(config), prepared_(prepared) {}

  /// The submap nearest to each request, in order. Where clouds are missing, the submap is empty.
  std::vector<SubmapPtr> get(std::span<const SubmapRequest> requests, CloudSource& source);

  /// The session's keyframes are about to move.
  void forget(SessionId session);

 private:
  struct Key {
    SessionId session = 0;
    std::size_t keyframe = 0;
    auto operator<=>(const Key&) const = default;
  };
  struct Entry {
    SubmapPtr submap;
    std::uint64_t clouds = 0;  // a hash of the numbers of those it was made of
  };
  /// A submap that is being built.
  struct Build {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    std::vector<const Keyframe*> window;  // keyframes whose clouds are stored
    std::vector<PlacedCloud> clouds;
    SubmapPtr submap;
  };
  void fetch_clouds(std::map<Key, Build>& builds, CloudSource& source);
  void keep(const Key& key, SubmapPtr submap, std::uint64_t clouds);
  void let_go(const Submap& submap);

  std::size_t capacity_bytes_;
  int threads_;
  SubmapConfig config_;
  CloudCache& prepared_;
  std::size_t bytes_ = 0;
  LruMap<Key, Entry> kept_;
  std::map<const SightImage*, std::size_t> looked_from_;  // how many submaps use each image
};

}  // namespace headframe
