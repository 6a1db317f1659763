#pragma once
// What the operator's views show of a session, and the work that is still to be done for all sessions.

#include <cstdint>
#include <optional>
#include <string>

#include "common/session/keyframe.hpp"
#include "common/session/live_state.hpp"
#include "server/session/ids.hpp"

namespace headframe {

/// The last state that a robot reported.
struct LiveRow {
  LiveState state;
  double age_s = 0;        // since it was reported
  std::uint64_t news = 0;  // counts reports: another number means another state
};

struct SessionRow {
  SessionId id = 0;
  SessionKey key;
  FamilyId family;
  Sensor sensor;
  bool connected = false;
  bool complete = false;  // the robot said that no further keyframe follows
  std::uint64_t keyframes = 0;
  std::uint64_t clouds = 0;  // stored
  std::uint64_t bytes_received = 0;
  std::uint64_t backlog = 0;  // keyframes that the robot still has to send, by its last report
  double bytes_per_s = 0;     // received, over the last ten seconds or so
  double link_age_s = -1;     // since anything was received from a connected robot; -1: it is not connected
  double distance_m = 0;
  double trigger_to_transform_ms = -1;  // from the trigger of the attempt that placed it; -1: not placed
  std::uint64_t cloud_bytes = 0;        // of bytes_received: encoded clouds
  std::string label = {};               // the operator's name for it; empty: none
  std::string why_cut = {};          // where its odometry jumped, and what happened to the rest; empty: it did not jump
  std::string why_aside = {};        // why it is set aside and not merged; empty: it is not set aside
  bool archived = false;             // kept, but left out of everything
  bool frozen = false;               // serves as reference: nothing moves it
  std::optional<LiveRow> live = {};  // nullopt: no report since the server started
  std::string note = {};             // the operator's note on it; empty: none
  std::uint64_t let_go = 0;          // clouds that were deleted to make room for others
  std::string site = {};             // the operator's name for the mine it was driven in; empty: there is only one
  std::uint64_t moves = 0;           // how often its robot's SLAM moved keyframes, since the server started
};

/// The work that is left before the atlas is settled; all zero when it is.
struct Pending {
  std::size_t attempts = 0;         // queued or running
  std::size_t keyframes = 0;        // durable, not yet passed to the pipeline
  std::size_t awaited_submaps = 0;  // clouds requested from connected robots
  bool idle() const { return attempts + keyframes + awaited_submaps == 0; }
};

}  // namespace headframe
