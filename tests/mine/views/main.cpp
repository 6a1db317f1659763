// headframe-mine-views: writes what descriptors are trained on.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "tests/mine/tool.hpp"
#include "tests/mine/views/views.hpp"

namespace headframe::mine {
namespace {

/// What the mines of a training set are, in turn. Exact copies are not among them: nothing tells those apart.
constexpr std::array kinds_in_turn{Kind::varied, Kind::junctions, Kind::grid,   Kind::varied, Kind::room_and_pillar,
                                   Kind::varied, Kind::ramp,      Kind::varied, Kind::grid,   Kind::junctions,
                                   Kind::varied, Kind::straight};

int run(int argc, char** argv) {
  CLI::App app{"Scans of simulated mines as range images, for training descriptors"};
  std::uint64_t seed = 100000;
  int mines = 12, routes = 6;
  double length_m = 110, spacing_m = 2;
  std::string dir;
  app.add_option("--seed", seed, "of the first mine; the others follow");
  app.add_option("--mines", mines, "how many")->check(CLI::Range(1, 100000));
  app.add_option("--routes", routes, "in each mine; every one is driven twice")->check(CLI::Range(1, 1000));
  app.add_option("--length", length_m, "metres of each drive")->check(CLI::Range(10.0, 1000.0));
  app.add_option("--spacing", spacing_m, "metres between scans")->check(CLI::Range(0.5, 10.0));
  app.add_option("--out", dir, "folder to write to")->required();
  CLI11_PARSE(app, argc, argv);
  std::filesystem::create_directories(dir);
  std::size_t total = 0;
  for (int i = 0; i < mines; ++i) {
    const Kind kind = kinds_in_turn[static_cast<std::size_t>(i) % kinds_in_turn.size()];
    const std::uint64_t mine = seed + static_cast<std::uint64_t>(i);
    const auto file = std::filesystem::path(dir) / (std::to_string(mine) + ".views");
    if (std::filesystem::exists(file)) continue;  // a run that was cut short goes on
    const Views views = take_views(kind, mine, routes, length_m, spacing_m);
    auto part = file;
    part += ".part";
    if (auto ok = write_views(views, part); !ok) {
      std::fprintf(stderr, "headframe-mine-views: %s\n", ok.error().message.c_str());
      return 1;
    }
    std::filesystem::rename(part, file);
    total += views.views.size();
    std::printf("%d of %d: %s %llu, %zu views, %zu in all\n", i + 1, mines, std::string(to_string(kind)).c_str(),
                static_cast<unsigned long long>(mine), views.views.size(), total);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace headframe::mine

int main(int argc, char** argv) {
  return headframe::mine::run_tool("headframe-mine-views", headframe::mine::run, argc, argv);
}
