#pragma once
// How the server names what it keeps. Ids are given by the store, in the order of arrival, and never used again.

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
