#pragma once

#include "server/merge/session_map.hpp"
#include "server/merge/submap_cache.hpp"
#include "server/verification/verification.hpp"

namespace headframe {

/// The submaps of all sessions, built when first needed and kept within a memory limit. Not thread safe.
class SessionSubmaps {
 public:
  SessionSubmaps(const MergeConfig& config, const SessionMap& sessions);

  /// The configuration of the far submaps, for the long-range check: free space only, as far as the lidars see.
  static SubmapConfig far_config();

  SubmapRequest at(SessionId id, std::size_t keyframe) const;
  std::vector<SubmapPtr> near(std::span<const SubmapRequest> requests, CloudSource& clouds) {
    return near_.get(requests, clouds);
  }
  std::vector<SubmapPtr> far(std::span<const SubmapRequest> requests, CloudSource& clouds) {
    return far_.get(requests, clouds);
  }

  /// The submaps around keyframes of both sessions where they meet.
  std::vector<SubmapPair> near(const OrderedPair& pair, std::span<const Meeting> meetings, CloudSource& clouds);

  /// The two sessions as the judge sees them, restricted to these keyframes. `this` and `clouds` must outlive it.
  Scene scene(const OrderedPair& pair, std::vector<KeyframePosition> a, std::vector<KeyframePosition> b,
              CloudSource& clouds);

  /// Prepares the cloud for registration ahead of the attempt that needs it.
  void prepare_cloud(const KeyframeRef& keyframe, CloudSource& clouds) { clouds_.get(keyframe, clouds); }

  /// Builds the next submap along the session's path ahead of attempts; false: none is left whose surroundings are
  /// complete.
  bool prepare_next(SessionId id, CloudSource& clouds);

  /// No submaps are built ahead for the session's present keyframes.
  void leave_for_attempts(SessionId id) { made_ahead_[id] = sessions_.at(id).keyframes.size(); }

  /// The session's keyframes change. Prepared clouds stay, because they are in the frames of their sensors.
  void forget(SessionId id) {
    made_ahead_.erase(id);
    near_.forget(id);
    far_.forget(id);
  }

 private:
  const SessionMap& sessions_;
  CloudCache clouds_;
  SubmapCache near_, far_;
  std::map<SessionId, std::size_t> made_ahead_;  // keyframes whose submaps were built ahead
};

}  // namespace headframe
