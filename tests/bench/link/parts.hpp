#pragma once
// The parts of ./run bench link: each measures, prints its table and gives its figures; null when a program failed.

#include <cstdint>

#include "tests/bench/link/kills.hpp"
#include "tests/bench/link/link.hpp"
#include "tests/bench/link/load.hpp"

namespace headframe::bench {

/// before: figures that were saved; those of an interrupted campaign with the same seed are gone on from. `save` is
/// given the figures after each block.
nlohmann::json link_kills(const KillPlan& plan, const nlohmann::json& before,
                          const std::function<void(const nlohmann::json&)>& save);

/// All bad radios at the same time, each with robots and a server of its own.
nlohmann::json link_faults(double seconds, std::uint32_t seed);

/// The plan, then if wanted ever more robots for 30 s until the bar of 250 ms breaks.
nlohmann::json link_load(const LoadPlan& plan, bool until_it_breaks);

/// The plan over SQLite and over a PostgreSQL of its own on the same disk, in turn, twice.
nlohmann::json link_stores(LoadPlan plan);

}  // namespace headframe::bench
