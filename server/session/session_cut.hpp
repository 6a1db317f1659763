#pragma once

#include <cstdint>
#include <string>

namespace headframe {

/// Where a session's odometry jumped, or its keyframes lie too far apart: what follows hangs on what was before by
/// nothing, and is left out of merging it.
struct SessionCut {
  std::uint64_t from = 0;  // the first keyframe that is left out, and all after it; 0: none is
  bool for_good = false;   // so many were that none is taken in any more
  std::string why = {};    // for people; empty: from is 0

  bool operator==(const SessionCut&) const = default;
};

}  // namespace headframe
