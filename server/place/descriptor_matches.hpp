#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/session/keyframe.hpp"

namespace headframe {

/// A neighbour of a keyframe of b among the keyframes of a, by index.
struct MatchedPair {
  std::size_t a = 0;
  std::size_t b = 0;
  float squared_distance = 0;
};

/// What proposes where b lies on a: for each keyframe of b its five nearest of a by place vector, nearest first; ties
/// go to the earlier. Keyframes without a place vector, or with another length than a's first, match nothing.
std::vector<MatchedPair> match_descriptors(std::span<const Keyframe> a, std::span<const Keyframe> b, int threads);

}  // namespace headframe
