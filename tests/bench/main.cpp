// ./run bench: figures as ratios against a reference in the same run, as a table and as JSON.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "server/place/wall_search.hpp"
#include "tests/bench/basin.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/merges.hpp"
#include "tests/bench/registration.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe::bench {
namespace {

/// Median over the runs, after one that is not counted.
template <class Work>
double median_ms(int runs, Work&& work) {
  std::vector<double> ms;
  for (int i = 0; i <= runs; ++i) {
    const double once = wall_ms(work);
    if (i > 0) ms.push_back(once);
  }
  return median(ms);
}

nlohmann::json walls() {
  const test::BoxMine mine(
      {test::BoxMine::drift(0, 0, 120, 0), test::BoxMine::drift(30, 0, 30, 60), test::BoxMine::drift(80, -40, 80, 0)});
  const auto a = test::drive(mine, {{2, 0}, {30, 0}, {30, 58}}, 0, 1), b = test::drive(mine, {{118, 0}, {2, 0}}, 1, 2);
  const WallMap map_a = draw_wall_map(a.keyframes, 1), map_b = draw_wall_map(b.keyframes, 1);
  const WallField field(map_a);
  const double ms = median_ms(5, [&] { search_walls(map_a, field, map_b, 20, 2); });
  std::printf("places\n  one pair of wall maps over all shifts and turns: %.0f ms (2 threads)\n", ms);
  return {{"wall_search_ms", ms}};
}

}  // namespace
}  // namespace headframe::bench

int main(int argc, char** argv) {
  using namespace headframe::bench;
  const std::string what = argc > 1 ? argv[1] : "all";
  const std::filesystem::path recordings = argc > 2 ? argv[2] : "../shared/data", out = "build/bench";
  std::filesystem::create_directories(out);
  bool known = false, missing = false;
  const auto part = [&](const char* name, auto&& measure) {
    if (what != "all" && what != name) return;
    known = true;
    nlohmann::json figures = measure();
    missing = missing || figures.is_null();
    if (!figures.contains(name)) figures = {{name, figures}};
    std::ofstream(out / (std::string(name) + ".json")) << figures.dump(1) << "\n";
  };
  part("registration", [&] {
    nlohmann::json figures;
    figures["registration"] = registration(recordings);
    figures["sampling"] = sampling();
    return figures;
  });
  part("places", [] { return walls(); });
  if (what == "merges")  // minutes: only when asked for
    part("merges", [&] {
      nlohmann::json figures;
      const int mines = argc > 3 ? std::atoi(argv[3]) : 56;
      figures["recordings"] = recordings_crossed(recordings);
      figures["merges"] = campaign(mines, out / "merges");
      figures["merge"] = merge_times();
      return figures;
    });
  if (what == "recordings") part("recordings", [&] { return recordings_crossed(recordings); });
  if (what == "merge-times") part("merge-times", merge_times);
  if (what == "basin") part("basin", [&] { return basin(out); });  // minutes: only when asked for
  if (!known)
    std::fprintf(stderr,
                 "headframe-bench: no bench '%s'; there are: registration, places, all; minutes each: basin, merges, "
                 "recordings, merge-times, link\n",
                 what.c_str());
  return !known ? 2 : missing ? 1 : 0;
}
