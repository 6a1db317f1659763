#pragma once
// What a robot's bytes mean, once they were checked.

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "common/session/keyframe_pose.hpp"
#include "common/session/map_question.hpp"
#include "common/wire/convert.hpp"

namespace headframe {

struct HelloReceived {
  Hello hello;
};
struct KeyframeReceived {
  Keyframe keyframe;          // never a hole: the sequence goes up by one, or repeats what was received before
  std::uint64_t backlog = 0;  // keyframes that the robot still has to send after it
};
struct PosesReceived {              // whole
  std::uint64_t number = 0;         // of the update
  std::uint64_t keyframes = 0;      // that came before it
  std::vector<KeyframePose> poses;  // of those, by rising sequence
};
struct CloudArrived {          // whole; to be answered by RobotProtocol::checked() before the next event is asked for
  std::uint64_t sequence = 0;  // of a keyframe that was received before
  std::string encoded;
};
struct CloudReceived {
  std::uint64_t sequence = 0;  // of a keyframe that was received before
  std::string encoded;         // it decodes
};
struct CloudRefused {  // the robot is told so, and drops it
  std::uint64_t sequence = 0;
  std::string reason;
};
struct CloudsUnavailable {
  std::vector<std::uint64_t> sequences;
};
struct TriggerRequested {
  std::string reason;
};
struct WhereAsked {
  bool asks = true;  // false: no more
};
/// What others know around the robot.
enum class SurroundingsKind { trajectories, coverage, map };
struct SurroundingsAsked {  // trajectories or coverage
  SurroundingsKind kind = SurroundingsKind::trajectories;
  bool asks = true;  // false: no more
  HeldVersion held;
};
struct MapAsked {
  std::uint64_t id = 0;
  Region region;  // as the robot wrote it, in its local frame
  double resolution_m = 0;
  HeldVersion since;
};
struct MapNextAsked {
  std::uint64_t id = 0;
  std::uint32_t offset = 0;
};
struct LiveReceived {
  LiveState state;
  std::uint64_t backlog = 0;  // as in KeyframeReceived
};
struct GoodbyeReceived {
  bool complete = false;
};
struct ProbeReceived {  // to be answered by RobotProtocol::resume() before the next event is asked for
  bool keyframe_follows = false;
};
struct TakenOver {};  // this connection carries the session from now on
using RobotEvent = std::variant<HelloReceived, KeyframeReceived, PosesReceived, CloudArrived, CloudReceived,
                                CloudRefused, CloudsUnavailable, TriggerRequested, WhereAsked, SurroundingsAsked,
                                MapAsked, MapNextAsked, LiveReceived, GoodbyeReceived, ProbeReceived, TakenOver>;

/// How robots may send: told to each when it changes.
struct LinkPolicy {
  std::uint64_t bytes_per_s = 0;  // of each robot; 0: no limit
  std::string hold;               // not empty: no keyframes and clouds for now, and why
  std::string cut = {};           // not empty: why the session's last keyframes are left out of merging
  bool operator==(const LinkPolicy&) const = default;
};

/// What is on disk of a session.
struct Durable {
  std::uint64_t keyframes = 0;        // all sequences up to here
  std::vector<std::uint64_t> clouds;  // sorted
  std::uint64_t pose_update = 0;      // the newest of the robot's
};

}  // namespace headframe
