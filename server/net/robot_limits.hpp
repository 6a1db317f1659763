#pragma once

namespace headframe {

/// What one robot's connection may take ([limits] in the configuration file); defaults live only here.
struct RobotLimits {
  int robots = 64;               // connected at a time
  int sessions = 8;              // of one robot, connected at a time
  int sessions_a_day = 200;      // that one robot may begin
  int keyframes_a_day = 100000;  // that one robot may send, and ...
  int stored_mib_a_day = 16384;  // ... with its clouds; both are kept in memory or on the disk for good
  int strangers = 256;    // connections that were not let in yet, of a robot that seeks the link up to four; one more,
                          // and the oldest of them is closed
  int spares = 8;         // connections of one robot beside the one that carries its session; one more, and the oldest
                          // of them is closed
  int undurable_mib = 4;  // received and not yet on disk: beyond, its socket is not read until the disk has caught up
  int uplink_kib_s = 0;   // what all robots together may send, shared by those that are connected; 0: no limit
  double hello_s = 10;    // a connection that says nothing useful for so long is closed
  double silence_s = 75;  // so is one that was welcomed and falls silent: longer than a link may be dark
  double ping_s = 10;     // silence after which it is asked; a spare asks by itself
  double write_s = 30;    // a robot that takes no bytes for so long is closed
};

}  // namespace headframe
