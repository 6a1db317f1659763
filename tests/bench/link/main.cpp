#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>

#include "tests/bench/link/parts.hpp"

namespace headframe::bench {
namespace {

nlohmann::json saved(const std::filesystem::path& path) {
  nlohmann::json all;
  if (std::ifstream in(path); in) all = nlohmann::json::parse(in, nullptr, false);
  if (!all.is_object()) all = nlohmann::json::object();
  if (!all["link"].is_object()) all["link"] = nlohmann::json::object();
  return all;
}

/// New figures replace old ones of the same name; the others stay.
void save(const std::filesystem::path& path, const nlohmann::json& figures) {
  nlohmann::json all = saved(path);
  all["link"].update(figures);
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path) << all.dump(1) << "\n";
}

bool clean(const nlohmann::json& figures) {
  if (figures.is_null()) return false;
  for (const char* bad : {"lost", "duplicated", "corrupted", "clouds_corrupted", "radio_faults", "overflows"})
    if (figures.value(bad, 0) != 0) return false;
  if (figures.contains("hostile") && figures["hostile"].value("deaths", 0) != 0) return false;
  return true;
}

/// Figures are printed and join those in `out`/link.json. Exit status: 1 when something was lost, duplicated or
/// corrupted, or a program failed.
int link_main(int argc, char** argv, const std::filesystem::path& out) {
  CLI::App app("What the link costs and what it stands; without a part: all of them.", "./run bench link");
  KillPlan kill_plan;
  auto* bytes_part = app.add_subcommand("bytes", "bytes of a keyframe and of a point");
  auto* merge_part = app.add_subcommand("merge", "bytes that a merge of two robots of the demo costs");
  double around_seconds = 60;
  auto* around_part = app.add_subcommand("around", "a thin link that is never without answers about others");
  around_part->add_option("--seconds", around_seconds, "alone, and beside the answers")->capture_default_str();
  double hostile_seconds = 5;
  std::string hostile_only;
  auto* hostile_part = app.add_subcommand("hostile", "what honest robots notice of attacks, each kind by itself");
  hostile_part->add_option("--seconds", hostile_seconds, "of each attack")->capture_default_str();
  hostile_part->add_option("--only", hostile_only, "attacks whose names have these words");
  auto* kills_part = app.add_subcommand(
      "kills", "kill -9 of server and robots under load, all compared; goes on where it was interrupted");
  kills_part->add_option("--count", kill_plan.count, "kills")->capture_default_str();
  kills_part->add_option("--seed", kill_plan.seed)->capture_default_str();
  double seconds = 310;
  std::uint32_t seed = 1;
  auto* faults_part = app.add_subcommand("faults", "loss, delay, a thin link, blackouts: needs root for namespaces");
  faults_part->add_option("--seconds", seconds, "under each condition")->capture_default_str();
  faults_part->add_option("--seed", seed)->capture_default_str();
  LoadPlan load_plan;
  bool until_it_breaks = false;
  auto* load_part = app.add_subcommand("load", "many robots on one server on this machine");
  load_part->add_option("--robots", load_plan.robots)->capture_default_str();
  load_part->add_option("--seconds", load_plan.seconds)->capture_default_str();
  load_part->add_option("--points", load_plan.points, "of each cloud")->capture_default_str();
  load_part->add_option("--caches-mb", load_plan.caches_mb, "each of the server's merge caches; 0: as it is");
  load_part->add_flag("--until-it-breaks", until_it_breaks, "then ever more robots, 30 s each");
  LoadPlan store_plan{.robots = 50, .seconds = 40};
  auto* stores_part = app.add_subcommand("stores", "what PostgreSQL costs beside SQLite; only when it is named");
  stores_part->add_option("--robots", store_plan.robots)->capture_default_str();
  stores_part->add_option("--seconds", store_plan.seconds)->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  spdlog::set_level(spdlog::level::off);  // servers that run in this process
  const bool all = app.get_subcommands().empty();
  until_it_breaks = until_it_breaks || all;
  bool good = true;
  const auto part = [&](const CLI::App* chosen, auto&& measure) {
    if (!all && !chosen->parsed()) return;
    const nlohmann::json figures = measure();
    good = clean(figures) && good;
    if (figures.is_object()) save(out / "link.json", figures);
    std::fflush(stdout);
  };
  part(bytes_part, link_bytes);
  part(merge_part, link_merge);
  part(around_part, [&] { return link_around(around_seconds); });
  part(hostile_part, [&] { return link_hostile(hostile_seconds, hostile_only); });
  part(kills_part, [&] {
    return link_kills(kill_plan, saved(out / "link.json")["link"],
                      [&](const nlohmann::json& so_far) { save(out / "link.json", so_far); });
  });
  part(faults_part, [&] { return link_faults(seconds, seed); });
  part(load_part, [&] { return link_load(load_plan, until_it_breaks); });
  if (stores_part->parsed()) part(stores_part, [&] { return link_stores(store_plan); });
  return good ? 0 : 1;
}

}  // namespace
}  // namespace headframe::bench

int main(int argc, char** argv) { return headframe::bench::link_main(argc, argv, "build/bench"); }
