#pragma once
// ./run bench years: what one more session costs a base station that has kept many.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

namespace headframe::bench {

struct YearsBench {
  std::vector<std::size_t> stored{10, 100, 1000};  // sessions, each in a mine of its own
  std::size_t keyframes = 100;                     // of each
  std::size_t visits = 5;                          // sessions that then come, each into the mine of one that is stored
  std::filesystem::path out;                       // the database is kept there, so that the next run need not draw it
};

/// With so many sessions stored: how long a start takes and what memory it has then; for each visit the time from the
/// end of its upload until it is told that it is merged, and until nothing is left to try, and whether it was merged
/// rightly. The merge worker and the SQLite file are those of the product; sockets are left out. Stored sessions count
/// as tried, and as free of copies.
nlohmann::json years(const YearsBench& bench);

}  // namespace headframe::bench
