#pragma once
// ./run bench stages DIR...: at which stage is a pair of sessions lost?

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/pipeline_run.hpp"

namespace headframe::bench {

struct StagesBench {
  std::vector<std::filesystem::path> sets;  // data sets, or folders of them
  std::vector<std::string> families;        // of descriptors: the robots of a set take these in turn
  double days_apart = 0;                    // between the drives, by their stamps
  Clouds clouds = Clouds::at_once;
  std::filesystem::path out;
};

/// For every pair of sessions in the data sets (each with truth.json and truth/ROBOT.txt): is the right placement
/// proposed (and at which rank), does screening keep it, what does the verdict say of the true placement, is the pair
/// merged, rightly or wrongly, how long the attempt takes, and which share of the clouds it takes. Pairs are counted by
/// the share of rock that both saw. A table on stdout; in `out` a line for each pair (stages.csv), for each placement
/// that was judged (verdict_sets.csv), and how far the verdict's probabilities can be believed (verdict.json,
/// reliability.png). Throws when a data set cannot be read.
nlohmann::json stages(const StagesBench& bench);

/// The same for every two sessions of different data sets whose worlds have one name (up to the first hyphen): many
/// pairs that share nothing, among copies, from few drives. In place of the share of rock stands the share of the path
/// that lies within 8 m of the other's. Lines in stages_crossed.csv.
nlohmann::json stages_crossed(const StagesBench& bench);

}  // namespace headframe::bench
