#include "tests/bench/years/partners.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>

#include "common/descriptor/family.hpp"
#include "server/merge/pair_search.hpp"
#include "server/merge/partner_promise.hpp"
#include "server/merge/partner_ranking.hpp"
#include "tests/bench/made_sets.hpp"

namespace headframe::bench {
namespace {

constexpr double near_m = 8;
constexpr std::array least_shared_m{40, 20, 10};
constexpr double never = std::numeric_limits<double>::infinity();

/// Of b's true path, what runs near a's.
double shared_m(const test::TruePath& a, const test::TruePath& b) {
  double out = 0;
  for (std::size_t j = 1; j < b.T_world_sensor.size(); ++j) {
    const Eigen::Vector3d here = b.T_world_sensor[j].translation();
    const bool near = std::any_of(a.T_world_sensor.begin(), a.T_world_sensor.end(),
                                  [&](const Pose& T) { return (T.translation() - here).norm() < near_m; });
    if (near) out += (here - b.T_world_sensor[j - 1].translation()).norm();
  }
  return out;
}

std::vector<DrivenSession> all_sessions(const std::vector<std::filesystem::path>& folders) {
  std::vector<DrivenSession> out;
  const auto sets = sets_below(folders);
  for (const auto& set : sets) {
    for (auto& [robot, session] : sessions_of(set, {std::string(default_family_name)})) {
      session.clouds.clear();
      out.push_back(std::move(session));
    }
    std::fprintf(stderr, "\r%zu of %zu data sets", static_cast<std::size_t>(&set - sets.data()) + 1, sets.size());
  }
  std::fprintf(stderr, "\n");
  return out;
}

/// Those that an attempt of each session tries, in this order.
std::vector<std::vector<SessionId>> partners_of_all(const MergeConfig& config, const SessionMap& sessions,
                                                    PartnerRanking& ranking) {
  HypothesisFinder finder(finder_config(config));
  PartnerPromise promise(config, sessions, finder);
  std::vector<std::vector<SessionId>> out;
  for (const auto& [id, session] : sessions.all()) {
    const std::vector<SessionId> ranked = ranking.rank(id, sessions);
    auto chosen = promise.choose(id, ranked);
    while (!chosen) chosen = promise.choose(id, ranked);
    out.push_back(std::move(*chosen));
    std::fprintf(stderr, "\r%zu of %zu sessions ranked", out.size(), sessions.all().size());
  }
  std::fprintf(stderr, "\n");
  return out;
}

}  // namespace

nlohmann::json partners(const std::vector<std::filesystem::path>& folders) {
  const std::vector<DrivenSession> driven = all_sessions(folders);
  const std::size_t n = driven.size();
  const MergeConfig config;
  SessionMap sessions(config);
  PartnerRanking ranking(config);
  for (std::size_t i = 0; i < n; ++i) {
    const auto id = static_cast<SessionId>(i) + 1;
    sessions.add(id, driven[i].family);
    for (const Keyframe& k : driven[i].keyframes) ranking.add(id, sessions.add_keyframe(id, k), sessions);
    sessions.complete(id);
  }
  const std::vector<std::vector<SessionId>> tried = partners_of_all(config, sessions, ranking);
  std::vector<std::vector<double>> shared(n, std::vector<double>(n, 0));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      if (i != j && kind_of(driven[i].world) == kind_of(driven[j].world))
        shared[i][j] = shared_m(driven[i].path, driven[j].path);
  // Sessions that share nothing with `of` and come before `wanted`.
  const auto before_it = [&](std::size_t of, std::size_t wanted) {
    double count = 0;
    for (const SessionId id : tried[of]) {
      const auto other = static_cast<std::size_t>(id - 1);
      if (other == wanted) return count;
      count += shared[of][other] == 0 && shared[other][of] == 0;
    }
    return never;
  };
  std::array<std::vector<double>, least_shared_m.size()> tries;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      const double m = std::min(shared[i][j], shared[j][i]);
      const auto bin =
          std::find_if(least_shared_m.begin(), least_shared_m.end(), [&](int least) { return m >= least; });
      if (bin != least_shared_m.end())
        tries[static_cast<std::size_t>(bin - least_shared_m.begin())].push_back(
            std::min(before_it(i, j), before_it(j, i)));
    }
  const int in_vain = config.most_in_vain(n - 1);
  nlohmann::json out{{"sessions", n}};
  std::printf("partners: %zu sessions in one database; an attempt ends after %d that came to nothing\n", n, in_vain);
  std::size_t all_tried = 0;
  for (const auto& list : tried) all_tried += std::min(list.size(), static_cast<std::size_t>(in_vain));
  std::printf("  %.1f are tried on average, if none gives anything\n",
              static_cast<double>(all_tried) / static_cast<double>(n));
  std::printf("  path shared   pairs   found before 4   8   %d have\n", in_vain);
  for (std::size_t bin = 0; bin < tries.size(); ++bin) {
    const auto before = [&](int most) {
      return static_cast<int>(std::count_if(tries[bin].begin(), tries[bin].end(), [&](double x) { return x < most; }));
    };
    std::printf("  %7d m +   %5zu   %14d   %3d   %3d\n", least_shared_m[bin], tries[bin].size(), before(4), before(8),
                before(in_vain));
    out["from_" + std::to_string(least_shared_m[bin]) + "_m"] = {{"pairs", tries[bin].size()},
                                                                 {"found", before(in_vain)}};
  }
  return out;
}

}  // namespace headframe::bench
