#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>

#include "tests/bench/link/kills.hpp"
#include "tests/bench/link/link.hpp"
#include "tests/support/base_station.hpp"

namespace headframe::bench {
namespace {

/// New figures replace old ones of the same name; the others stay.
void save(const std::filesystem::path& path, const nlohmann::json& figures) {
  nlohmann::json all;
  if (std::ifstream in(path); in) all = nlohmann::json::parse(in, nullptr, false);
  if (!all.is_object()) all = nlohmann::json::object();
  all["link"].update(figures);
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path) << all.dump(1) << "\n";
}

/// Null when a program failed.
nlohmann::json kills(const KillPlan& plan) {
  const test::ScratchFolder scratch;
  const auto outcome = kill_campaign(plan, scratch.path());
  if (!outcome) return std::fprintf(stderr, "link kills: %s\n", outcome.error().message.c_str()), nlohmann::json();
  const Faults& f = outcome->faults;
  const auto n = [](std::uint64_t v) { return static_cast<unsigned long long>(v); };
  std::printf(
      "link kills (seed %u)\n  %d kills, %d of them of the server; %d compares; %llu keyframes and %llu clouds\n",
      plan.seed, outcome->kills, outcome->server_kills, outcome->compares, n(f.keyframes), n(f.clouds));
  std::printf("  lost %llu, duplicated %llu, corrupted %llu; clouds lost %llu, corrupted %llu %s\n", n(f.lost),
              n(f.duplicated), n(f.corrupted), n(f.clouds_lost), n(f.clouds_corrupted), f.first.c_str());
  return {{"kills", outcome->kills},
          {"lost", f.lost + f.clouds_lost},
          {"duplicated", f.duplicated},
          {"corrupted", f.corrupted},
          {"clouds_lost", f.clouds_lost},
          {"clouds_corrupted", f.clouds_corrupted},
          {"kill_keyframes", f.keyframes},
          {"kill_clouds", f.clouds},
          {"kill_compares", outcome->compares},
          {"server_kills", outcome->server_kills}};
}

bool clean(const nlohmann::json& figures) {
  if (figures.is_null()) return false;
  for (const char* bad : {"lost", "duplicated", "corrupted", "clouds_corrupted"})
    if (figures.value(bad, 0) != 0) return false;
  return true;
}

}  // namespace

int link_main(int argc, char** argv, const std::filesystem::path& out) {
  CLI::App app("What the link costs and what it stands; without a part: all of them.", "headframe-bench link");
  KillPlan kill_plan;
  auto* bytes_part = app.add_subcommand("bytes", "bytes of a keyframe and of a point");
  auto* kills_part = app.add_subcommand("kills", "kill -9 of server and robots under load, all compared");
  kills_part->add_option("--count", kill_plan.count, "kills")->capture_default_str();
  kills_part->add_option("--seed", kill_plan.seed)->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const bool all = app.get_subcommands().empty();
  bool good = true;
  const auto part = [&](const CLI::App* chosen, auto&& measure) {
    if (!all && !chosen->parsed()) return;
    const nlohmann::json figures = measure();
    good = clean(figures) && good;
    if (figures.is_object()) save(out / "link.json", figures);
    std::fflush(stdout);
  };
  part(bytes_part, link_bytes);
  part(kills_part, [&] { return kills(kill_plan); });
  return good ? 0 : 1;
}

}  // namespace headframe::bench
