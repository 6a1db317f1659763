#pragma once
// Ids of stored objects. The store assigns them in order of arrival and never reuses them.

#include <compare>
#include <cstdint>

namespace headframe {

using SessionId = std::int64_t;
using AlignmentId = std::int64_t;

/// A keyframe by its session and its number in it, from 1 on.
struct KeyframeRef {
  SessionId session = 0;
  std::uint64_t sequence = 0;
  auto operator<=>(const KeyframeRef&) const = default;
};

}  // namespace headframe
