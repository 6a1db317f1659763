#pragma once

#include <functional>

#include "common/cloud/point_cloud.hpp"
#include "common/result.hpp"
#include "server/session/ids.hpp"

namespace headframe {

enum class CloudState {
  stored,        // load() returns it
  obtainable,    // its robot is connected and answers submap requests
  unobtainable,  // no robot can be asked for it now
  let_go,        // it was stored once and was deleted to make room for others
};

/// Decodes a cloud that was read, into its keyframe's sensor frame. May be called from any thread.
using CloudDecoder = std::function<Result<KeyframeCloud>()>;

/// Where the merge pipeline gets clouds from. Called from the pipeline's thread.
class CloudSource {
 public:
  virtual ~CloudSource() = default;
  virtual CloudState state(const KeyframeRef& keyframe) const = 0;
  /// Reads a cloud. The result is used before the source ends.
  virtual Result<CloudDecoder> load(const KeyframeRef& keyframe) = 0;
  /// Called before work on two sessions, or on one (a == b), begins, so that a hang or crash can be traced to them.
  virtual void working_on(SessionId /*a*/, SessionId /*b*/) {}
};

}  // namespace headframe
