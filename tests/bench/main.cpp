// ./run bench: figures as ratios against a reference in the same run, as a table and as JSON.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/descriptor/family.hpp"
#include "server/place/wall_search.hpp"
#include "tests/bench/basin.hpp"
#include "tests/bench/coverage.hpp"
#include "tests/bench/descriptors/descriptors.hpp"
#include "tests/bench/live/live.hpp"
#include "tests/bench/localize.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/merges.hpp"
#include "tests/bench/one_map.hpp"
#include "tests/bench/pose_graph.hpp"
#include "tests/bench/registration.hpp"
#include "tests/bench/rejudge.hpp"
#include "tests/bench/stages.hpp"
#include "tests/bench/years/partners.hpp"
#include "tests/bench/years/years.hpp"
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
  const double ms = median_ms(5, [&] { search_walls(map_a, field, map_b, 20, {}, 2); });
  std::printf("places\n  one pair of wall maps over all shifts and turns: %.0f ms (2 threads)\n", ms);
  return {{"wall_search_ms", ms}};
}

struct Options {
  std::string what = "all";
  std::filesystem::path recordings = "../shared/data", out = "build/bench";
  std::optional<int> mines;
  std::vector<std::filesystem::path> sets;                                  // of stages
  std::vector<std::filesystem::path> rows;                                  // of rejudge
  bool crossed = false;                                                     // sessions of different sets
  bool on_request = false;                                                  // the clouds of stages
  double days_apart = 0;                                                    // sessions of stages
  std::vector<std::string> set_families{std::string(default_family_name)};  // the robots take them in turn
  std::vector<std::string> families{"learned", "scan_context", "lidar_iris"};
  std::optional<std::uint64_t> first_seed;
  std::vector<std::string> mine_kinds;  // of drawn-mines
  LiveBench live = {};
  YearsBench years = {};
  bool years_graph = false;
  LocalizeBench localize = {};

  LiveBench live_bench() const {
    LiveBench bench = live;
    bench.recordings = recordings;
    bench.out = out;
    return bench;
  }
};

int fail(const std::string& message, int status) {
  std::fprintf(stderr, "headframe-bench: %s\n", message.c_str());
  return status;
}

nlohmann::json drawn_mines(const Options& options, Clouds clouds, const char* folder) {
  Campaign campaign{.mines = options.mines.value_or(Campaign{}.mines),
                    .clouds = clouds,
                    .out = options.out / folder,
                    .first_seed = options.first_seed.value_or(Campaign{}.first_seed)};
  if (!options.mine_kinds.empty()) campaign.kinds.clear();
  for (const std::string& name : options.mine_kinds) {
    const auto kind = mine::kind_of(name);
    if (!kind) throw std::runtime_error("there is no kind of mine '" + name + "'; there are " + mine::kind_list());
    campaign.kinds.push_back(*kind);
  }
  return run_campaign(campaign);
}

nlohmann::json merges(const Options& options) {
  nlohmann::json figures;
  figures["recordings"] = recordings_crossed(options.recordings, options.out);
  figures["merges"] = drawn_mines(options, Clouds::at_once, "merges");
  figures["merge"] = merge_times();
  return figures;
}

nlohmann::json pose_graph_of(const Options& options) {
  const PoseGraphBench usual;
  return pose_graph({options.sets, options.mines.value_or(usual.mines), options.first_seed.value_or(usual.first_seed),
                     options.out / "pose-graph"});
}

nlohmann::json descriptor_families(const Options& options) {
  DescriptorBench bench{options.families, options.recordings, options.out / "descriptors"};
  bench.mines = options.mines.value_or(bench.mines);
  auto figures = descriptors(bench);
  if (!figures) throw std::runtime_error(figures.error().message);
  return std::move(*figures);
}

int run(const Options& options) {
  std::error_code failed;
  std::filesystem::create_directories(options.out, failed);
  if (failed)
    return fail(options.out.string() + " cannot be made: " + failed.message() + "; run it in a folder you may write to",
                1);
  bool known = false, missing = false;
  const auto part = [&](const char* name, bool in_all, auto&& measure) {
    if (options.what != name && !(in_all && options.what == "all")) return;
    known = true;
    nlohmann::json figures = measure();
    missing = missing || figures.is_null();
    if (!figures.contains(name)) figures = {{name, figures}};
    std::ofstream(options.out / (std::string(name) + ".json")) << figures.dump(1) << "\n";
  };
  part("registration", true, [&] {
    nlohmann::json figures;
    figures["registration"] = registration(options.recordings);
    figures["sampling"] = sampling();
    return figures;
  });
  part("places", true, walls);
  // Minutes: only when asked for.
  part("merges", false, [&] { return merges(options); });
  part("drawn-mines", false, [&] { return drawn_mines(options, Clouds::at_once, "drawn-mines"); });
  part("merges-on-request", false, [&] { return drawn_mines(options, Clouds::on_request, "merges-on-request"); });
  part("recordings", false, [&] { return recordings_crossed(options.recordings, options.out); });
  part("merge-times", false, merge_times);
  part("stages", false, [&] {
    const StagesBench bench{options.sets, options.set_families, options.days_apart,
                            options.on_request ? Clouds::on_request : Clouds::at_once, options.out};
    return (options.crossed ? stages_crossed : stages)(bench);
  });
  part("localize", false, [&] {
    LocalizeBench bench = options.localize;
    bench.out = options.out;
    return localize(bench);
  });
  part("coverage", false, [&] { return coverage({.recordings = options.recordings}); });
  part("live", false, [&] { return live(options.live_bench()); });
  part("years", false, [&] {
    YearsBench bench = options.years;
    bench.out = options.out;
    nlohmann::json figures = years(bench);
    if (options.years_graph) {
      figures.update(pose_graph_of(options));
      figures["optimise_s"] = figures.at("scale").at("optimise_s");
    }
    return figures;
  });
  part("rejudge", false, [&] { return rejudge(options.rows, options.out / "rejudged.csv"); });
  part("partners", false, [&] { return partners(options.sets); });
  part("one-map", false, [&] { return one_map(options.sets); });
  part("pose-graph", false, [&] { return pose_graph_of(options); });
  part("pose-graph-scale", false, [] { return pose_graph_scale(1000, 3000); });
  part("basin", false, [&] { return basin(options.out); });
  part("descriptors", false, [&] { return descriptor_families(options); });
  if (known) return missing ? 1 : 0;
  return fail(
      "no bench '" + options.what +
          "'; there are: registration, places, all; minutes each: basin, merges, drawn-mines, merges-on-request, "
          "recordings, merge-times, stages, rejudge, localize, coverage, live, years, partners, one-map, pose-graph, "
          "pose-graph-scale, descriptors, link",
      2);
}

}  // namespace
}  // namespace headframe::bench

int main(int argc, char** argv) {
  using namespace headframe::bench;
  Options options;
  CLI::App app{"Measures; the figures also land in build/bench/WHAT.json"};
  app.add_option(
      "WHAT", options.what,
      "registration, places, basin, merges (which is recordings, drawn-mines and merge-times), merges-on-request, "
      "descriptors; all");
  app.add_option("RECORDINGS", options.recordings, "folder of the data sets");
  app.add_option("MINES", options.mines, "of merges: mines in all; of descriptors: of each kind")
      ->check(CLI::Range(1, 1000));
  app.add_option("--first-seed", options.first_seed, "of the drawn mines; others than those reported, to set weights");
  app.add_option("--kinds", options.mine_kinds,
                 "of the drawn mines: comma separated; none: all but varied and tiled_cave")
      ->delimiter(',');
  app.add_option("--families", options.families, "of descriptors: comma separated, as robots take them")
      ->delimiter(',');
  auto* stages = app.add_subcommand("stages", "at which stage pairs of sessions are lost");
  stages->add_option("DIR", options.sets, "data sets (with truth.json and truth/ROBOT.txt), or folders of them")
      ->required();
  stages->add_flag("--crossed", options.crossed, "every two sessions of different sets of one world instead");
  stages->add_flag("--on-request", options.on_request, "robots send the clouds that the server asks for");
  stages->add_option("--family", options.set_families, "of descriptors: the robots of a set take these in turn")
      ->delimiter(',')
      ->allow_extra_args(false);
  stages->add_option("--days-apart", options.days_apart, "so many days lie between the drives, by their stamps");
  stages->callback([&options] { options.what = "stages"; });
  auto* rejudge = app.add_subcommand("rejudge", "placements that were judged before, with the verdict of this build");
  rejudge->add_option("ROWS", options.rows, "verdict*.csv of stages, merges, recordings or drawn-mines")->required();
  rejudge->callback([&options] { options.what = "rejudge"; });
  auto* localize = app.add_subcommand("localize", "robots wake up in a mapped mine and ask where they are");
  localize->add_option("DIR", options.localize.sets, "data sets (as of stages), or folders of them")->required();
  localize->add_option("--starts", options.localize.starts, "along each drive")->check(CLI::Range(1, 1000));
  localize->add_option("--driven", options.localize.driven_m, "metres that each drives")->check(CLI::Range(1, 1000));
  localize->add_option("--step", options.localize.step_m, "metres between two questions")->check(CLI::Range(1, 1000));
  localize->add_flag("--rests", options.localize.rests, "each robot stops, and what is merged then is judged");
  localize->callback([&options] { options.what = "localize"; });
  auto* graph = app.add_subcommand("pose-graph", "keyframes against the truth, before and after the pose graph");
  graph->add_option("DIR", options.sets, "data sets (as of stages), or folders of them, besides drawn mines");
  graph->add_option("--mines", options.mines, "of each kind");
  graph->callback([&options] { options.what = "pose-graph"; });
  auto* live = app.add_subcommand("live", "robots drive while the server merges; all that stood, against the truth");
  auto* driven = live->add_option("DIR", options.live.sets,
                                  "data sets (as of stages), or folders of them; none: recordings, mines");
  live->add_option("--family", options.live.families, "of descriptors: the robots of a set in DIR take these in turn")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->needs(driven);
  live->add_option("--only", options.live.only, "sets whose names contain this");
  live->add_option("--conditions", options.live.conditions, "drives whose conditions contain this, as \"link lost\"");
  live->add_option("--seed", options.live.first_seed, "of the first drawn mine");
  auto* years = app.add_subcommand("years", "what one more session costs a base station that has kept many");
  auto* stored = years->add_option("--stored", options.years.stored,
                                   "sessions, comma separated; none: 10, 100, 1000, and then the pose graph");
  stored->delimiter(',');
  years->add_option("--keyframes", options.years.keyframes, "of each")->check(CLI::Range(30, 10000));
  years->add_option("--visits", options.years.visits, "sessions that then come")->check(CLI::Range(1, 100));
  auto* partners = app.add_subcommand("partners", "is the right session among those that one is tried with");
  partners->add_option("DIR", options.sets, "data sets (as of stages), or folders of them")->required();
  partners->callback([&options] { options.what = "partners"; });
  auto* one_map = app.add_subcommand("one-map", "do all drives through a mine become one map");
  one_map->add_option("DIR", options.sets, "data sets (as of stages), or folders of them")->required();
  one_map->callback([&options] { options.what = "one-map"; });
  years->callback([&options, stored] {
    options.what = "years";
    options.years_graph = stored->empty();
  });
  live->callback([&options] { options.what = "live"; });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    return run(options);
  } catch (const std::exception& error) {
    return fail(error.what(), 1);
  }
}
