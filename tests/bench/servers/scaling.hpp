#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "common/result.hpp"
#include "tests/support/postgres_cluster.hpp"

namespace headframe::bench {

struct ScalingPlan {
  std::size_t sessions = 16, visits = 3;  // each in a mine of its own, but for the visits
  std::size_t keyframes = 60;             // of a session
  int pairs = 5;                          // of runs
};

/// Merges what is stored, from the start of the active server until every session has been tried, alone and beside a
/// server that stands by. Each server has a core of its own, PostgreSQL that of the active one. Runs alternate.
/// after_run is told the figures so far. Fails when a program does not start or does not finish.
Result<nlohmann::json> scaling(const ScalingPlan& plan, test::PostgresCluster& cluster,
                               const std::filesystem::path& scratch,
                               const std::function<void(const nlohmann::json&)>& after_run);

/// This process, and those that it starts from now on, run on this core alone.
void run_on_core(int core);

}  // namespace headframe::bench
