#pragma once

namespace headframe {

/// When sessions are tried ([merge] in the configuration file); defaults live only here.
struct ScheduleConfig {
  double travelled_m = 10;  // path driven since the session's last try
  double junction_m = 5;    // the same for a session that has reached a junction since
  double submap_s = 30;     // without any cloud from a robot, until its requested clouds are given up
  double rest_s = 120;      // without a keyframe, until an unfinished session counts as complete ...
  double asked_rest_s = 3;  // ... and after its robot asked for a merge
  double awaited_s = 600;   // per hour: how long merges of others may wait for a robot's growing sessions
  double stuck_s = 120;     // on one session or pair: after this, /readyz reports that merging is stuck ...
  double budget_s = 900;    // ... and after this, the work is given up and counts against the sessions
};

}  // namespace headframe
