#include "tests/bench/one_map.hpp"

#include <algorithm>
#include <cstdio>

#include "common/descriptor/family.hpp"
#include "tests/bench/made_sets.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/pair_study.hpp"
#include "tests/bench/pipeline_run.hpp"

namespace headframe::bench {
namespace {

constexpr double meet_pct = 18;

struct Counts {
  int sessions = 0, components = 0, largest = 0, meet = 0, joined = 0, published = 0, wrong = 0;
  std::vector<double> ms = {};  // of the attempt of each session

  nlohmann::json json() const {
    return {{"sessions", sessions}, {"components", components},
            {"largest", largest},   {"meet", meet},
            {"joined", joined},     {"published", published},
            {"wrong", wrong},       {"attempt_p50_ms", quantile(ms, 0.5)}};
  }
};

/// By the drives' world; all sessions of one world count as sessions of one mine.
std::map<std::string, std::vector<DrivenSession>> by_world(const std::vector<std::filesystem::path>& folders) {
  std::map<std::string, std::vector<DrivenSession>> out;
  for (const auto& set : sets_below(folders))
    for (auto& [robot, session] : sessions_of(set, {std::string(default_family_name)})) {
      const std::string kind = kind_of(session.world);
      session.world = kind;
      out[kind].push_back(std::move(session));
    }
  return out;
}

bool in_one_component(const Atlas& atlas, SessionId a, SessionId b) {
  return std::any_of(atlas.components.begin(), atlas.components.end(), [&](const Component& component) {
    return placement_in(component, a) && placement_in(component, b);
  });
}

Counts merge_all(const std::vector<DrivenSession>& sessions) {
  Counts out;
  PipelineRun run;
  for (const DrivenSession& session : sessions) {
    const SessionId id = run.add(session);
    out.ms.push_back(wall_ms([&] { run.attempt(id); }));
    std::fprintf(stderr, "\r%s: session %llu of %zu", session.world.c_str(), static_cast<unsigned long long>(id),
                 sessions.size());
  }
  std::fprintf(stderr, "\n");
  const Atlas& atlas = run.pipeline.atlas();
  out.sessions = static_cast<int>(sessions.size());
  out.components = static_cast<int>(atlas.components.size());
  for (const Component& component : atlas.components)
    out.largest = std::max(out.largest, static_cast<int>(component.placements.size()));
  for (std::size_t i = 0; i < sessions.size(); ++i)
    for (std::size_t j = i + 1; j < sessions.size(); ++j) {
      const auto a = static_cast<SessionId>(i + 1), b = static_cast<SessionId>(j + 1);
      const bool meet = path_in_common(sessions[i], sessions[j]).overlap_pct >= meet_pct;
      out.meet += meet;
      out.joined += meet && in_one_component(atlas, a, b);
      const Outcome outcome = judge_outcome(run, a, b);
      out.published += outcome.merged;
      out.wrong += outcome.merged && !outcome.right;
      if (outcome.merged && !outcome.right)
        std::printf("    %s and %s: merged wrongly, %.1f m off\n", sessions[i].name.c_str(), sessions[j].name.c_str(),
                    outcome.error.translation_m);
    }
  return out;
}

}  // namespace

nlohmann::json one_map(const std::vector<std::filesystem::path>& folders) {
  const auto worlds = by_world(folders);
  nlohmann::json out;
  std::printf("one-map: all sessions of a world in one database\n  %-12s %8s %10s %7s %11s %10s %6s %9s\n", "",
              "sessions", "components", "largest", "pairs meet", "in one map", "wrong", "p50 ms");
  int wrong = 0;
  for (const auto& [world, sessions] : worlds) {
    const Counts counts = merge_all(sessions);
    wrong += counts.wrong;
    std::printf("  %-12s %8d %10d %7d %11d %10d %6d %9.0f\n", world.c_str(), counts.sessions, counts.components,
                counts.largest, counts.meet, counts.joined, counts.wrong, quantile(counts.ms, 0.5));
    out[world] = counts.json();
  }
  out["false"] = wrong;
  return out;
}

}  // namespace headframe::bench
