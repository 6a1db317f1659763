#pragma once
// Simulated mines of the bench: none of them is ever trained on.

#include <algorithm>
#include <array>
#include <cstdint>

#include "tests/bench/descriptors/views.hpp"

namespace headframe::bench {

constexpr std::uint64_t first_own_seed = 9000;  // training digs from 100000 on, its validation in the 90000s
constexpr double bench_dust = 0.03;

/// The rows of the own mines as a whole are over the first four. In straight drifts and exact copies places can hardly
/// be told apart by their nature: they are given by themselves, as is `varied`.
constexpr std::array own_kinds{mine::Kind::junctions, mine::Kind::grid,     mine::Kind::room_and_pillar,
                               mine::Kind::ramp,      mine::Kind::straight, mine::Kind::look_alike,
                               mine::Kind::varied};
constexpr bool in_headline(mine::Kind kind) {
  return std::find(own_kinds.begin(), own_kinds.begin() + 4, kind) != own_kinds.begin() + 4;
}

/// Two drives that share about half: a is the database; b asks, seen by the same lidar and by another.
struct Drives {
  Drive a, b_same, b_cross;
};

struct OwnMine {
  mine::Kind kind = mine::Kind::junctions;
  std::uint64_t seed = 0;
  Drives clean;
  Drives dusty;                              // of the headline's kinds only
  Truth same, cross;                         // from the clean scans
  std::vector<bool> junction_a, junction_b;  // three or more ways lead on
};

/// The same arguments give the same scans. Fails as make_scenario does.
Result<OwnMine> dig(mine::Kind kind, std::uint64_t seed);

/// A drive whose scans have about 32000 points.
Result<mine::Recording> dense_recording();

}  // namespace headframe::bench
