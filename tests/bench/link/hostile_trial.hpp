#pragma once
// One kind of attack on one server, with honest robots beside it.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "tests/support/hostile_peers.hpp"

namespace headframe::bench {

struct Attack {
  std::string name;
  std::function<void(const test::HostileTarget&)> act;  // empty: nobody attacks
};

struct Trial {
  std::vector<double> ack_ms;  // of the honest robots' keyframes, while the attack goes on
  double merge_s = 0;          // from the goodbye of two honest robots to the atlas that has them together
  int acts = 0;                // how often the attack was made
  std::string death;           // the server died, hung, or did not come back; empty: all was well
};

/// A fresh server in `scratch`. Six honest robots send ten keyframes a second each, with their clouds; two more come
/// with a drive each that overlaps the other's, and go. Afterwards the server has to answer, to end by SIGTERM, and to
/// start again with the two still merged. A failure is of the bench itself.
Result<Trial> hostile_trial(const Attack& attack, double seconds, const std::filesystem::path& scratch);

}  // namespace headframe::bench
