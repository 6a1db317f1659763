#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace headframe {

/// How far a robot's session has come on its way to the server.
struct Progress {
  std::uint64_t keyframes = 0;  // of the session, in the spool
  std::uint64_t keyframes_acknowledged = 0;
  std::uint64_t pose_updates = 0;  // RobotClient::update_poses() of the session
  std::uint64_t pose_updates_acknowledged = 0;
  bool pose_updates_unsupported = false;  // the server is older than they are: they wait in the spool for a newer one
  std::uint64_t clouds_waiting = 0;       // in the spool, not acknowledged
  std::uint64_t clouds_acknowledged = 0;
  std::uint64_t clouds_dropped = 0;  // by the quota, damaged, or refused
  std::uint64_t clouds_refused = 0;  // by the server, since open()
  std::uint64_t bytes_sent = 0;      // since open()
  bool connected = false;
  bool refused = false;                          // the server said no for good: nothing more is tried
  double server_bytes_per_s = 0;                 // what the server lets it send; 0: no limit
  std::vector<std::string> server_capabilities;  // as its last welcome listed them; empty: it is older than the list
  std::string hold;                              // why the server takes nothing for now (a full disk); empty: it does
  std::string cut;          // where the odometry jumped, and what became of what followed; empty: it did not
  std::string link_error;   // why the last connection ended; empty: none did
  std::string cloud_error;  // why the last cloud was dropped that was damaged or refused; empty: none was
};

}  // namespace headframe
