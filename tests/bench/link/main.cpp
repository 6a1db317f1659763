#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <thread>

#include "tests/bench/link/faults.hpp"
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

/// All conditions at the same time, each over a radio of its own. Null when one could not be driven.
nlohmann::json faults(double seconds, std::uint32_t seed) {
  const test::ScratchFolder scratch;
  const auto radios = bad_radios();
  std::vector<Result<FaultOutcome>> outcomes(radios.size());
  std::vector<std::thread> threads;
  threads.reserve(radios.size());
  for (std::size_t i = 0; i < radios.size(); ++i)
    threads.emplace_back([&, i] {
      FaultPlan plan;
      plan.radio = radios[i];
      plan.seconds = seconds;
      plan.seed = seed + static_cast<std::uint32_t>(i);
      outcomes[i] = drive_over(plan, scratch.path() / std::to_string(i));
    });
  for (auto& thread : threads) thread.join();
  nlohmann::json rows = nlohmann::json::array(), figures;
  std::uint64_t wrong = 0;
  std::printf(
      "link faults (%.0f s each, 4 robots, a keyframe a second with its cloud; bounds in server to robot and back)\n"
      "  radio             keyframes  lag p50 s  p95 s  max s  recovery p95 s  clouds meanwhile  lost  doubled  "
      "corrupt\n",
      seconds);
  for (const auto& done : outcomes) {
    if (!done) return std::fprintf(stderr, "link faults: %s\n", done.error().message.c_str()), nlohmann::json();
    const auto& f = done->faults;
    const double p50 = quantile(done->lag_s, 0.5), p95 = quantile(done->lag_s, 0.95), most = quantile(done->lag_s, 1);
    const double recovery = quantile(done->recovery_s, 0.95);
    std::printf("  %-16s %10llu %10.2f %6.2f %6.2f %15.2f %17llu %5llu %8llu %8llu %s\n", done->name.c_str(),
                static_cast<unsigned long long>(f.keyframes), p50, p95, most, recovery,
                static_cast<unsigned long long>(done->clouds), static_cast<unsigned long long>(f.lost + f.clouds_lost),
                static_cast<unsigned long long>(f.duplicated),
                static_cast<unsigned long long>(f.corrupted + f.clouds_corrupted), f.first.c_str());
    wrong += f.sum();
    rows.push_back({{"radio", done->name},
                    {"keyframes", f.keyframes},
                    {"lag_p50_s", p50},
                    {"lag_p95_s", p95},
                    {"lag_max_s", most},
                    {"recovery_p95_s", recovery},
                    {"clouds", done->clouds},
                    {"bytes", done->bytes},
                    {"faults", f.sum()}});
  }
  return {{"radios", rows},
          {"radio_faults", wrong},
          {"recovery_p95_s", rows[3]["recovery_p95_s"]},
          {"recovery_together_p95_s", rows[4]["recovery_p95_s"]},
          {"lag_64kbit_max_s", rows[2]["lag_max_s"]}};
}

bool clean(const nlohmann::json& figures) {
  if (figures.is_null()) return false;
  for (const char* bad : {"lost", "duplicated", "corrupted", "clouds_corrupted", "radio_faults"})
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
  double seconds = 310;
  std::uint32_t seed = 1;
  auto* faults_part = app.add_subcommand("faults", "loss, delay, a thin link, blackouts: needs root for namespaces");
  faults_part->add_option("--seconds", seconds, "under each condition")->capture_default_str();
  faults_part->add_option("--seed", seed)->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  spdlog::set_level(spdlog::level::off);  // servers that run in this process
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
  part(faults_part, [&] { return faults(seconds, seed); });
  return good ? 0 : 1;
}

}  // namespace headframe::bench
