#pragma once

#include <optional>
#include <span>
#include <string>

#include "common/session/keyframe.hpp"

namespace headframe {

/// Whether no robot can have driven from one keyframe to the next; if so, returns the reason in words, else nullopt. A
/// jump is a distance of more than 25 m, over which two keyframes need not have seen the same rock; a speed of more
/// than 30 m/s; or a climb steeper than 45 degrees, unless it could be a drone's (up to 10 m, neither too fast nor too
/// slow). Odometry says nothing about how the two sides of a jump lie. `earlier`: the session's keyframes so far. A
/// robot that drives back along its own path makes no keyframes there, so a keyframe beside an earlier one that saw the
/// same walls is not a jump of distance or climb. Pure.
std::optional<std::string> jump_between(const Keyframe& before, const Keyframe& after,
                                        std::span<const Keyframe> earlier = {});

}  // namespace headframe
