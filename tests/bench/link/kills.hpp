#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "tests/bench/link/audit.hpp"

namespace headframe::bench {

struct KillPlan {
  int count = 300;
  std::uint32_t seed = 1;
  int robots = 3;
  int kills_a_block = 20;  // then the robots may finish, all is compared, and new ones begin
  std::uint64_t keyframes = 700;
  int every_ms = 10;  // a keyframe and its cloud, each robot
  /// A PostgreSQL that the server writes to and that is killed as well; none: SQLite.
  struct Postgres {
    std::function<Result<std::string>()> make_database;  // an empty one; its URL
    std::function<void()> kill;
    std::function<Result<void>()> start;  // after that; ready when it returns
  };
  std::optional<Postgres> postgres = std::nullopt;
};

struct KillOutcome {
  int kills = 0;  // processes killed with SIGKILL
  int server_kills = 0, database_kills = 0;
  int compares = 0;
  Faults faults;
};

/// Kills the server, a robot, or all at seeded moments under load; restarts them in a seeded order; compares after
/// every restart. Real processes over TLS, data below `scratch`. `outcome` has what earlier blocks of the same plan
/// came to, so that a campaign may be interrupted between them; after_block is told after each. Fails when a program
/// does not start or does not finish.
Result<KillOutcome> kill_campaign(const KillPlan& plan, const std::filesystem::path& scratch, KillOutcome outcome = {},
                                  const std::function<void(const KillOutcome&)>& after_block = {});

}  // namespace headframe::bench
