#pragma once
// ./run bench localize DIR...: where is a robot that wakes up somewhere in a mapped mine?

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

namespace headframe::bench {

struct LocalizeBench {
  std::vector<std::filesystem::path> sets;  // data sets (with truth.json and truth/ROBOT.txt), or folders of them
  int starts = 4;                           // along each other drive, in each kind of rock
  double driven_m = 30, step_m = 5;         // of each start; asked after each step
  bool rests = false;                       // it does not ask, but stops: what is merged then is judged
  std::filesystem::path out;
};

/// Every session is a map in turn. Robots wake up along the other session of its data set and along those of the next
/// set through the same world, each in a local frame of its own, and ask where they are while they drive. Right: within
/// 0.5 m and 2 deg where they are then; wrong: beyond 1 m or 3 deg, or told in rock that the map does not hold. A table
/// on stdout; a line for each question (localize.csv) in `out`. Throws when a data set can not be read.
nlohmann::json localize(const LocalizeBench& bench);

}  // namespace headframe::bench
