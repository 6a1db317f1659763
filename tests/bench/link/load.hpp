#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace headframe::bench {

/// Processor seconds that the process has used so far; 0 if there is none.
double cpu_s(int pid);

struct LoadPlan {
  int robots = 200;            // each a keyframe a second with its cloud
  double seconds = 600;        // after all have connected
  int points = 3000;           // of a cloud: some 7 KB
  std::string store_url = {};  // postgresql://...; empty: SQLite
  bool standby = false;        // with PostgreSQL: a second server waits meanwhile, and robots know both
  bool relayed = false;        // then: of the robots, every second one knows that one alone
  int caches_mb = 0;           // each of the server's caches for merging; 0: its defaults. Small ones are full soon
};

struct LoadOutcome {
  int robots = 0;
  double ack_p50_ms = 0, ack_p99_ms = 0, ack_max_ms = 0;  // keyframe added to its ack seen, at most 5 ms late
  std::uint64_t keyframes = 0;                            // added
  std::uint64_t unacknowledged = 0;                       // two seconds after the last
  std::uint64_t broken_links = 0;                         // connections that ended: a full queue, a refusal, a deadline
  std::string broken_why;                                 // the first
  double rss_mb = 0;                                      // of the server, at the end
  double rss_growth_mb = 0;                               // ... over the time after its first minute (or tenth)
  double rss_growth_half_mb = 0;                          // ... over the second half, when its caches are full
  double server_cores = 0, robots_cores = 0;              // busy on the average
  double standby_cores = 0;                               // of the server that waits
  double late_ms = 0;  // by which the bench itself added keyframes too late, at worst
};

/// headframe-server as a process with its data in `scratch`, over TLS; all robots in this process; their spools are not
/// synced, since robots have disks of their own.
Result<LoadOutcome> load(const LoadPlan& plan, const std::filesystem::path& scratch,
                         const std::filesystem::path& spools);

}  // namespace headframe::bench
