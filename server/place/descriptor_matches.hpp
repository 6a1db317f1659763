#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/session/keyframe.hpp"

namespace headframe {

/// A keyframe of b and one of its nearest neighbours among the keyframes of a, by index.
struct MatchedPair {
  std::size_t a = 0;
  std::size_t b = 0;
  float squared_distance = 0;
};

/// For each keyframe of b its five nearest of a by place vector, nearest first; equally near ones in order of index.
/// Keyframes without a place vector, or with one of another length than that of a's first, match nothing.
std::vector<MatchedPair> match_descriptors(std::span<const Keyframe> a, std::span<const Keyframe> b, int threads);

}  // namespace headframe
