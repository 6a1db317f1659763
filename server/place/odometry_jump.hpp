#pragma once

#include <optional>
#include <span>
#include <string>

#include "common/session/keyframe.hpp"

namespace headframe {

/// Whether no robot drives from one keyframe to the next, and why, for people; nothing: it may well. Beyond 25 m apart
/// two keyframes need not have seen the same rock; nobody drives 30 m in a second; and no ramp goes up steeper than 45
/// degrees: only a drone does, by at most 10 m from one keyframe to the next, and neither at once nor at leisure. What
/// lies on both sides of a jump is held together by no odometry. `earlier`: the session's keyframes so far. A robot
/// that drives back over its own path makes no keyframes there, so the next one may lie anywhere beside that path, as
/// long as it sees what the keyframe beside it saw. Pure.
std::optional<std::string> jump_between(const Keyframe& before, const Keyframe& after,
                                        std::span<const Keyframe> earlier = {});

}  // namespace headframe
