#pragma once

namespace headframe {

/// When sessions are tried ([merge] in the configuration file); defaults live only here.
struct ScheduleConfig {
  double travelled_m = 10;  // along the trajectory, since the session's last try
  double junction_m = 5;    // the same for a session that has come to a junction since
  double submap_s = 30;     // without any cloud from a robot, until the clouds asked of it count as not coming
  double rest_s = 120;      // without a keyframe, until a session counts as complete though no goodbye came ...
  double asked_rest_s = 3;  // ... and after its robot asked for a merge
  double awaited_s = 600;   // in each hour merges of others may wait for a robot's sessions that grow
  double stuck_s = 120;     // on two sessions, or on one alone: longer, and /readyz says that merging is stuck ...
  double budget_s = 900;    // ... and after so long the work is given up, and counts against the sessions
};

}  // namespace headframe
