#pragma once

#include <cstdint>
#include <string>

namespace headframe {

/// The end of the usable part of a session whose odometry jumped, or whose keyframes lie too far apart: nothing
/// connects the later keyframes to the earlier ones, so they are left out of merging.
struct SessionCut {
  std::uint64_t from = 0;  // the first keyframe that is left out, with all after it; 0: none
  bool for_good = false;   // so many were left out that all later ones are too
  std::string why = {};    // in words; empty if from is 0

  bool operator==(const SessionCut&) const = default;
};

}  // namespace headframe
