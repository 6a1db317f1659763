#pragma once

#include <filesystem>
#include <vector>

#include "tests/bench/link/audit.hpp"
#include "tests/bench/link/bad_link.hpp"
#include "tests/bench/link/quantile.hpp"

namespace headframe::bench {

/// The bar's conditions, each alone and then together.
std::vector<RadioConditions> bad_radios();

struct FaultPlan {
  RadioConditions radio;
  double seconds = 300;  // under the conditions; then the radio is clear until all has arrived
  int robots = 4;        // each a keyframe a second, with its cloud
  std::uint32_t seed = 1;
};

struct FaultOutcome {
  Faults faults;                   // everything compared when all has arrived
  std::vector<double> lag_s;       // keyframe added to its ack, those made outside blackouts
  std::vector<double> recovery_s;  // end of a blackout to the next ack, each robot and blackout
  std::uint64_t clouds = 0;        // arrived under the conditions
  std::uint64_t bytes = 0;         // reached the server under the conditions, IP headers included
  void add(const FaultOutcome& other);
};

/// A server and robots in one process, a namespace each, the radio between them; TLS.
Result<FaultOutcome> drive_over(const FaultPlan& plan, const std::filesystem::path& scratch);

}  // namespace headframe::bench
