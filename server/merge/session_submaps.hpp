#pragma once

#include "server/merge/session_map.hpp"
#include "server/merge/submap_cache.hpp"
#include "server/verification/verification.hpp"

namespace headframe {

/// The submaps of all sessions, made when first asked for and kept while they fit. Not thread safe.
class SessionSubmaps {
 public:
  SessionSubmaps(const MergeConfig& config, const SessionMap& sessions);

  /// Of the far submaps, for the long-range check: free space alone, as far as the lidars see.
  static SubmapConfig far_config();

  SubmapRequest at(SessionId id, std::size_t keyframe) const;
  std::vector<SubmapPtr> near(std::span<const SubmapRequest> requests, CloudSource& clouds) {
    return near_.get(requests, clouds);
  }
  std::vector<SubmapPtr> far(std::span<const SubmapRequest> requests, CloudSource& clouds) {
    return far_.get(requests, clouds);
  }

  /// The session as the judge sees it, from these of its keyframes. It and `clouds` must outlive the scene.
  Scene scene(SessionId id, std::vector<KeyframePosition> positions, CloudSource& clouds);

  /// Makes the cloud ready for registration ahead of the attempt that needs it.
  void prepare_cloud(const KeyframeRef& keyframe, CloudSource& clouds) { clouds_.get(keyframe, clouds); }

  /// Makes the next submap of the session's path ahead; false: all whose surroundings are known by now are made.
  bool prepare_next(SessionId id, CloudSource& clouds);

  /// None of the keyframes that are here by now are made ahead.
  void leave_for_attempts(SessionId id) { made_ahead_[id] = sessions_.at(id).keyframes.size(); }

  /// Of a session that is still here. Clouds that are ready stay so: they lie in the frames of their sensors.
  void forget(SessionId id) {
    made_ahead_.erase(id);
    near_.forget(id);
    far_.forget(id);
  }

 private:
  const SessionMap& sessions_;
  CloudCache clouds_;
  SubmapCache near_, far_;
  std::map<SessionId, std::size_t> made_ahead_;  // keyframes whose submaps were
};

}  // namespace headframe
