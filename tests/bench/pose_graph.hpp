#pragma once
// ./run bench pose-graph: how far keyframes lie from the truth before and after the pose graph, and how long it takes.

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/bench/pipeline_run.hpp"

namespace headframe::bench {

struct PoseGraphBench {
  std::vector<std::filesystem::path> sets;  // data sets with their truth, or folders of them; none: drawn mines alone
  int mines = 4;                            // of each kind with loops
  std::uint64_t first_seed = 71000;
  std::filesystem::path out;  // pictures of loops before and after
};

/// Loops and galleries of drawn mines, and data sets. A table, and pictures.
nlohmann::json pose_graph(const PoseGraphBench& bench);

/// Robots in a drawn mine that drive round a loop of it; by what they do.
enum class Loop {
  one_robot,   // one drives round once, and a third of the way again
  two_robots,  // one drives two thirds of it, the other the rest from the same place the other way round
};
DrivenMine drive_loop(mine::Kind kind, std::uint64_t seed, double drift, Loop loop);

/// One component of so many sessions of 300 keyframes on a lattice of galleries: the whole of it at once, and one
/// session more.
nlohmann::json pose_graph_scale(std::size_t sessions, std::size_t alignments);

}  // namespace headframe::bench
