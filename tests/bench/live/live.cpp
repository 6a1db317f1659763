#include "tests/bench/live/live.hpp"

#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "tests/bench/live/live_report.hpp"
#include "tests/bench/live/live_sets.hpp"
#include "tests/bench/live/live_watch.hpp"

namespace headframe::bench {
namespace {

using Sessions = std::vector<DrivenSession>;

std::vector<const DrivenSession*> pointers(const Sessions& sessions) {
  std::vector<const DrivenSession*> out;
  for (const DrivenSession& session : sessions) out.push_back(&session);
  return out;
}

LiveDrive drive(const LiveSet& set, const LiveConditions& conditions, const Sessions& present, const Sessions& driving,
                std::optional<std::map<NamedPair, EndState>>& first_end) {
  LiveDrive out;
  out.set = set.name;
  out.kind = set.kind;
  out.conditions = text_of(conditions);
  LiveWatch watch;
  LiveRun run(pointers(present), pointers(driving), conditions, [&](const LiveRun& now) { watch.look(now); });
  try {
    run.drive();
  } catch (const std::exception& e) {
    throw std::runtime_error(set.name + " (" + out.conditions + "): " + e.what());
  }
  watch.look(run);
  auto end = LiveWatch::end_of(run);
  run.ask_for_merges();
  const auto asked = LiveWatch::end_of(run);
  out.asking_changed = differences(end, asked);
  watch.finish(run);
  out.wrong = watch.wrong();
  out.right = watch.right();
  out.claims = watch.claims();
  out.later_m = watch.later_m();
  out.wrong_provisional = watch.wrong_provisional();
  out.right_withdrawn = watch.right_withdrawn();
  out.attempts = run.attempts();
  for (const auto& [id, session] : run.sessions())
    for (const auto& [other, theirs] : run.sessions())
      out.meet += id < other && truly_meet(*session.driven, *theirs.driven);
  if (first_end)
    out.end_differs = differences(end, *first_end);
  else
    first_end = std::move(end);
  return out;
}

}  // namespace

nlohmann::json live(const LiveBench& bench) {
  std::filesystem::create_directories(bench.out);
  std::ofstream lines(bench.out / "live-drives.jsonl");
  std::vector<LiveDrive> drives;
  const auto sets =
      bench.sets.empty() ? live_sets(bench.recordings, bench.first_seed) : made_live_sets(bench.sets, bench.families);
  for (const LiveSet& set : sets) {
    if (set.name.find(bench.only) == std::string::npos) continue;
    const Sessions present = set.present(), driving = set.driving();
    std::optional<std::map<NamedPair, EndState>> first_end;
    for (const LiveConditions& conditions : set.conditions) {
      if (text_of(conditions).find(bench.conditions) == std::string::npos) continue;
      drives.push_back(drive(set, conditions, present, driving, first_end));
      print(drives.back());
      lines << to_json(drives.back()).dump() << std::endl;
    }
  }
  if (drives.empty())
    throw std::runtime_error("no drive has \"" + bench.only + "\" in its set's name and \"" + bench.conditions +
                             "\" in its conditions; without --only and --conditions all are driven");
  return summary(drives);
}

}  // namespace headframe::bench
