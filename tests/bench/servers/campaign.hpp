#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "tests/bench/link/audit.hpp"
#include "tests/bench/servers/revision_watch.hpp"
#include "tests/support/postgres_cluster.hpp"

namespace headframe::bench {

struct ServersPlan {
  int count = 100;  // kills
  std::uint32_t seed = 1;
  int robots = 3;          // that are killed too; one more is not, and tells when it is acknowledged again
  int kills_a_block = 20;  // then the robots may finish, all is compared, and everything begins anew
  int every_ms = 100;      // a keyframe and its cloud, each robot
};

struct ServersOutcome {
  int kills = 0;  // processes killed with SIGKILL, PostgreSQL counted as one; and servers that were cut off
  int active_kills = 0, cuts = 0, standby_kills = 0, database_kills = 0, robot_kills = 0;
  std::vector<double> failover_s;       // kill of the active server until a new keyframe is acknowledged
  std::vector<double> cut_s;            // the same of one that is halted and loses its connection
  std::vector<double> postgres_back_s;  // PostgreSQL takes connections again until a new keyframe is acknowledged
  int compares = 0;
  Faults faults;
  RevisionBook::Seen revisions;
};

/// Kills servers, PostgreSQL and robots at seeded moments, and halts active servers whose connection is cut meanwhile;
/// compares after each. Real processes over TLS, two servers on one database, data below `scratch`. after_block is told
/// after each block. Fails when a program does not start or does not finish, or a server that was cut off does not end.
Result<ServersOutcome> servers_campaign(const ServersPlan& plan, test::PostgresCluster& cluster,
                                        const std::filesystem::path& scratch,
                                        const std::function<void(const ServersOutcome&)>& after_block = {});

}  // namespace headframe::bench
