#pragma once
// What a robot's bytes mean, once they were checked.

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "common/wire/convert.hpp"

namespace headframe {

struct HelloReceived {
  Hello hello;
};
struct KeyframeReceived {
  Keyframe keyframe;  // never a hole: repeats aside, the sequence goes up by one
};
struct CloudReceived {
  std::uint64_t sequence = 0;  // of a keyframe that was received before
  std::string encoded;         // it decodes
};
struct CloudsUnavailable {
  std::vector<std::uint64_t> sequences;
};
struct TriggerRequested {
  std::string reason;
};
struct GoodbyeReceived {
  bool complete = false;
};
using RobotEvent =
    std::variant<HelloReceived, KeyframeReceived, CloudReceived, CloudsUnavailable, TriggerRequested, GoodbyeReceived>;

/// What is on disk of a session.
struct Durable {
  std::uint64_t keyframes = 0;        // all sequences up to here
  std::vector<std::uint64_t> clouds;  // sorted
};

}  // namespace headframe
