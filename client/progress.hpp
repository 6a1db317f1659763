#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace headframe {

/// How much of a robot's session has reached the server.
struct Progress {
  std::uint64_t keyframes = 0;  // of the session, in the spool
  std::uint64_t keyframes_acknowledged = 0;
  std::uint64_t pose_updates = 0;  // number of RobotClient::update_poses() of the session
  std::uint64_t pose_updates_acknowledged = 0;
  bool pose_updates_unsupported = false;  // the server does not support them; they wait in the spool for a newer one
  std::uint64_t clouds_waiting = 0;       // in the spool, not acknowledged
  std::uint64_t clouds_acknowledged = 0;
  std::uint64_t clouds_dropped = 0;  // by the quota, or because they were damaged or refused
  std::uint64_t clouds_refused = 0;  // by the server, since open()
  std::uint64_t bytes_sent = 0;      // since open()
  bool connected = false;
  bool refused = false;           // the server refused the robot for good; no further connection is tried
  double server_bytes_per_s = 0;  // the limit that the server sets; 0: none
  std::vector<std::string> server_capabilities;  // from its last welcome; empty: its version predates the list
  std::string hold;                              // why the server accepts nothing for now (a full disk); empty: it does
  std::string cut;          // where the odometry jumped, and what happened to the rest; empty: it did not jump
  std::string link_error;   // why the last connection ended; empty: none has ended
  std::string cloud_error;  // why the last damaged or refused cloud was dropped; empty: there was none
};

}  // namespace headframe
