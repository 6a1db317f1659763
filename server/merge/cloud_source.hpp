#pragma once

#include "common/cloud/point_cloud.hpp"
#include "common/result.hpp"
#include "server/session/ids.hpp"

namespace headframe {

enum class CloudState {
  stored,        // load() will give it
  obtainable,    // its robot is connected and answers submap requests
  unobtainable,  // nobody can be asked now
  let_go,        // it was here, and made room for others
};

/// Where the merge pipeline takes clouds from. Called from the thread that calls the pipeline.
class CloudSource {
 public:
  virtual ~CloudSource() = default;
  virtual CloudState state(const KeyframeRef& keyframe) const = 0;
  /// In the keyframe's sensor frame.
  virtual Result<KeyframeCloud> load(const KeyframeRef& keyframe) = 0;
  /// Told before work on two sessions, or on one, begins: should it never end well, it is known whose it was.
  virtual void working_on(SessionId /*a*/, SessionId /*b*/) {}
};

}  // namespace headframe
