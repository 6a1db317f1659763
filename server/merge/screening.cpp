#include "server/merge/screening.hpp"

#include <algorithm>

#include "server/session/same_placement.hpp"
#include "server/support/parallel.hpp"

namespace headframe {
namespace {

/// Long wrong overlaps match more of one place than short right ones, but their walls contradict. With 5 to 10 the same
/// pairs of third-party worlds merge, with 20 one fewer (tests/bench/README.md).
constexpr double contradicted = 7;

}  // namespace

JudgeConfig judge_config(const MergeConfig& config) {
  JudgeConfig judge;
  judge.threads = config.threads;
  judge.place.engine = config.registration;
  return judge;
}

std::vector<ScreeningResult> screen(const OrderedPair& pair, const std::vector<Case>& cases, SessionSubmaps& submaps,
                                    CloudSource& clouds, const JudgeConfig& judge) {
  std::vector<std::size_t> meet;  // cases
  std::vector<Meeting> where;
  std::vector<std::optional<Meeting>> meetings(cases.size());
  for_blocks(cases.size(), 1, judge.threads, [&](std::size_t i, std::size_t, std::size_t) {
    const Case& c = cases[i];
    meetings[i] = first_meeting(c.a.stored, c.b.stored, c.hypothesis.T_a_b, c.hypothesis.place_b, judge);
  });
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (!meetings[i]) continue;
    meet.push_back(i);
    where.push_back(*meetings[i]);
  }
  const std::vector<SubmapPair> at = submaps.near(pair, where, clouds);
  std::vector<Pose> T(meet.size());
  std::vector<std::pair<double, std::size_t>> order(meet.size());  // the likeliest first, then as proposed
  for_blocks(meet.size(), 1, judge.threads, [&](std::size_t i, std::size_t, std::size_t) {
    T[i] = cases[meet[i]].hypothesis.T_a_b;
    const double doubt = contradicted * cases[meet[i]].hypothesis.contradiction;
    order[i] = {-coarse_fit(*at[i].a, *at[i].b, T[i]) / (1 + doubt), i};
  });
  std::sort(order.begin(), order.end());
  if (order.size() > judge.screened_fully) order.resize(judge.screened_fully);
  std::vector<ScreeningResult> screened(cases.size());
  for_blocks(order.size(), 1, judge.threads, [&](std::size_t k, std::size_t, std::size_t) {
    const std::size_t i = order[k].second;
    screened[meet[i]] = screen_submaps(at[i].a, at[i].b, T[i], judge);
  });
  return screened;
}

SubmapPair first_place(const OrderedPair& pair, const Case& c, SessionSubmaps& submaps, CloudSource& clouds,
                       const JudgeConfig& judge) {
  const auto meeting = first_meeting(c.a.stored, c.b.stored, c.hypothesis.T_a_b, c.hypothesis.place_b, judge);
  if (!meeting) return {};
  return submaps.near(pair, {&*meeting, 1}, clouds).front();
}

double look_alikes(std::vector<ScreeningResult> screened, const Pose& T) {
  std::stable_sort(screened.begin(), screened.end(), [](const ScreeningResult& one, const ScreeningResult& other) {
    return likeness(one) > likeness(other);
  });
  std::vector<Pose> counted{T};
  double sum = 0;
  for (const ScreeningResult& result : screened) {
    const double alike = likeness(result);
    if (alike <= 0) break;
    const Pose& here = result.place.registration.T_target_source;
    const auto near = [&](const Pose& U) { return same_placement(here, U, result.place.p_b, same_look_alike); };
    if (std::any_of(counted.begin(), counted.end(), near)) continue;
    counted.push_back(here);
    sum += alike;
  }
  return sum;
}

}  // namespace headframe
