#pragma once
// What a session is to everyone above, and what is still to be done for all of them.

#include <cstdint>
#include <optional>
#include <string>

#include "common/session/keyframe.hpp"
#include "common/session/live_state.hpp"
#include "server/session/ids.hpp"

namespace headframe {

/// What a robot said last of itself.
struct LiveRow {
  LiveState state;
  double age_s = 0;        // since it was said
  std::uint64_t news = 0;  // how often it was said: another number, another state
};

struct SessionRow {
  SessionId id = 0;
  SessionKey key;
  FamilyId family;
  Sensor sensor;
  bool connected = false;
  bool complete = false;  // the robot said that no keyframe follows
  std::uint64_t keyframes = 0;
  std::uint64_t clouds = 0;  // stored
  std::uint64_t bytes_received = 0;
  std::uint64_t backlog = 0;  // keyframes that the robot still has to send, as it said last
  double bytes_per_s = 0;     // received, over the last ten seconds or so
  double link_age_s = -1;     // since anything was heard of a connected robot; -1: it is not connected
  double distance_m = 0;
  double trigger_to_transform_ms = -1;  // from the trigger of the attempt that placed it; -1: none has
  std::uint64_t cloud_bytes = 0;        // of bytes_received: encoded clouds
  std::string label = {};               // the operator's name for it; empty: none
  std::string why_cut = {};             // where its odometry jumped, and what became of the rest; empty: it did not
  std::string why_aside = {};           // it is set aside, not merged, and why; empty: it is merged
  bool archived = false;                // kept, and left out of everything
  bool frozen = false;                  // reference: nothing moves it
  std::optional<LiveRow> live = {};     // none: nothing since the server began
  std::string note = {};                // what the operator wants to be remembered of it; empty: nothing
  std::uint64_t let_go = 0;             // clouds that were stored and made room for others
  std::string site = {};                // the mine it was driven in, by the operator's name; empty: he has one alone
  std::uint64_t moves = 0;              // how often its robot's SLAM moved its past, since the server began
};

/// What has still to be done before the atlas is settled; all zero when it is.
struct Pending {
  std::size_t attempts = 0;         // queued or running
  std::size_t keyframes = 0;        // durable, not yet given to the pipeline
  std::size_t awaited_submaps = 0;  // clouds asked of connected robots
  bool idle() const { return attempts + keyframes + awaited_submaps == 0; }
};

}  // namespace headframe
