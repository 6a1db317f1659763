#include "server/merge/screening.hpp"

#include <algorithm>

#include "server/session/same_placement.hpp"
#include "server/support/parallel.hpp"

namespace headframe {
namespace {

/// Long wrong overlaps match more of one place than short right ones, but their walls contradict. With 5 to 10 the same
/// pairs of third-party worlds merge, with 20 one fewer (tests/bench/README.md).
constexpr double contradicted = 7;

/// The first place may say nothing, as at the foot of a ramp, where the nearest keyframes stand on two levels. Cases
/// that fail there, but were proposed before the first that does not, are tried at further places, if among the first
/// eight; when all were tried, the same pairs merged.
constexpr std::size_t looked_at_again = 8;

/// Of JudgeConfig::screened_fully. Of 394 pairs one more merges, and none fewer (tests/bench/README.md).
constexpr std::size_t screened_by_score = 3;

/// A case at one place of its overlap.
struct Look {
  std::size_t of = 0;  // the case
  Meeting where = {};
  SubmapPair at = {};
  Pose T_a_b = Pose::Identity();  // where a full registration starts
  double worth = 0;
};

/// The looks registered coarsely, the likeliest first, then as given. Where the keyframes stand far apart, a coarse
/// registration goes astray (verification/submap_check), so only its worth is used: the walls know the place better.
std::vector<Look> by_coarse_fit(std::vector<Look> looks, const OrderedPair& pair, const std::vector<Case>& cases,
                                SessionSubmaps& submaps, CloudSource& clouds, const JudgeConfig& judge) {
  std::vector<Meeting> where;
  where.reserve(looks.size());
  for (const Look& look : looks) where.push_back(look.where);
  const std::vector<SubmapPair> at = submaps.near(pair, where, clouds);
  for_blocks(looks.size(), 1, judge.threads, [&](std::size_t i, std::size_t, std::size_t) {
    Look& look = looks[i];
    const Hypothesis& h = cases[look.of].hypothesis;
    look.at = at[i];
    Pose T_coarse = h.T_a_b;
    look.worth = coarse_fit(*look.at.a, *look.at.b, T_coarse) / (1 + contradicted * h.contradiction);
    const bool beside = (h.T_a_b * look.at.b->p - look.at.a->p).norm() <= judge.place.beside_m;
    look.T_a_b = beside ? T_coarse : h.T_a_b;
  });
  std::stable_sort(looks.begin(), looks.end(), [](const Look& l, const Look& m) { return l.worth > m.worth; });
  return looks;
}

std::optional<Meeting> first_of(const Case& c, const JudgeConfig& judge) {
  return first_meeting(c.a.stored, c.b.stored, c.hypothesis.T_a_b, c.hypothesis.place_b, judge);
}

/// Where a case is looked at again. No two of its places are within 4 m, so that each has a submap of its own.
std::vector<Meeting> further_of(const Case& c, const Meeting& first, const JudgeConfig& judge) {
  const std::vector<KeyframePosition>&a = c.a.stored, &b = c.b.stored;
  const Pose& T = c.hypothesis.T_a_b;
  const auto at =
      std::find_if(b.begin(), b.end(), [&](const KeyframePosition& s) { return s.keyframe == first.keyframe_b; });
  const std::vector<KeyframePosition> places = further_places(a, b, T, at->p, judge);
  std::vector<Meeting> out(places.size());
  std::transform(places.begin(), places.end(), out.begin(), [&](const KeyframePosition& place) {
    return Meeting{nearest_to(a, T * place.p).position->keyframe, place.keyframe};
  });
  return out;
}

std::vector<Look> first_looks(const std::vector<Case>& cases, const JudgeConfig& judge) {
  std::vector<std::optional<Meeting>> meetings(cases.size());
  for_blocks(cases.size(), 1, judge.threads,
             [&](std::size_t i, std::size_t, std::size_t) { meetings[i] = first_of(cases[i], judge); });
  std::vector<Look> out;
  for (std::size_t i = 0; i < cases.size(); ++i)
    if (meetings[i]) out.push_back({.of = i, .where = *meetings[i]});
  return out;
}

/// Of the cases proposed before the first that is hopeful.
std::vector<Look> second_looks(const std::vector<Case>& cases, const std::vector<ScreeningResult>& screened,
                               const JudgeConfig& judge) {
  std::vector<Look> out;
  for (std::size_t i = 0; i < std::min(looked_at_again, cases.size()) && !screened[i].hopeful; ++i)
    if (const auto first = first_of(cases[i], judge))
      for (const Meeting& where : further_of(cases[i], *first, judge)) out.push_back({.of = i, .where = where});
  return out;
}

/// Keeps those that deserve a full registration. Where little of a place matches, walls farther off may tell: the last
/// seats are for the highest scores of the wall search.
void keep_promising(std::vector<Look>& looks, const std::vector<Case>& cases, const JudgeConfig& judge) {
  if (looks.size() <= judge.screened_fully) return;
  const auto rest = looks.begin() + static_cast<std::ptrdiff_t>(judge.screened_fully - screened_by_score);
  std::stable_sort(rest, looks.end(), [&](const Look& l, const Look& m) {
    return cases[l.of].hypothesis.score > cases[m.of].hypothesis.score;
  });
  looks.resize(judge.screened_fully);
}

std::vector<ScreeningResult> register_fully(const std::vector<Look>& looks, const JudgeConfig& judge) {
  std::vector<ScreeningResult> out(looks.size());
  for_blocks(looks.size(), 1, judge.threads, [&](std::size_t i, std::size_t, std::size_t) {
    out[i] = screen_submaps(looks[i].at.a, looks[i].at.b, looks[i].T_a_b, judge);
  });
  return out;
}

/// Whether one of the results led to the same placement.
bool known(const ScreeningResult& result, const std::vector<ScreeningResult>& screened) {
  const SubmapCheck& place = result.place;
  return std::any_of(screened.begin(), screened.end(), [&](const ScreeningResult& other) {
    return other.hopeful && same_placement(other.place.registration.T_target_source, place.registration.T_target_source,
                                           place.p_b, same_registration);
  });
}

}  // namespace

JudgeConfig judge_config(const MergeConfig& config) {
  JudgeConfig judge;
  judge.threads = config.threads;
  judge.place.engine = config.registration;
  return judge;
}

std::vector<ScreeningResult> screen(const OrderedPair& pair, const std::vector<Case>& cases, SessionSubmaps& submaps,
                                    CloudSource& clouds, const JudgeConfig& judge) {
  std::vector<ScreeningResult> screened(cases.size());
  std::vector<Look> looks = by_coarse_fit(first_looks(cases, judge), pair, cases, submaps, clouds, judge);
  keep_promising(looks, cases, judge);
  std::vector<ScreeningResult> results = register_fully(looks, judge);
  for (std::size_t i = 0; i < looks.size(); ++i) screened[looks[i].of] = std::move(results[i]);
  if (pair.a == pair.b) return screened;  // how a mine looks like itself is told by one place each
  looks = by_coarse_fit(second_looks(cases, screened, judge), pair, cases, submaps, clouds, judge);
  results = register_fully(looks, judge);
  for (std::size_t i = 0; i < looks.size(); ++i) {
    ScreeningResult& of_case = screened[looks[i].of];
    if (results[i].hopeful && !of_case.hopeful && !known(results[i], screened)) of_case = std::move(results[i]);
  }
  return screened;
}

SubmapPair place_screened(const OrderedPair& pair, const Case& c, const SubmapCheck& place, SessionSubmaps& submaps,
                          CloudSource& clouds, const JudgeConfig& judge) {
  const auto first = first_of(c, judge);
  if (!first) return {};
  std::vector<Meeting> all = further_of(c, *first, judge);
  all.insert(all.begin(), *first);
  for (const Meeting& where : all)  // one after the other, because submaps take long to build
    if (SubmapPair at = submaps.near(pair, {&where, 1}, clouds).front(); at.b->p == place.p_b) return at;
  return {};
}

double count_alike(std::vector<ScreeningResult> screened, const Pose& T, double (*alike)(const ScreeningResult&)) {
  std::stable_sort(screened.begin(), screened.end(),
                   [&](const ScreeningResult& one, const ScreeningResult& other) { return alike(one) > alike(other); });
  std::vector<Pose> counted{T};
  double sum = 0;
  for (const ScreeningResult& result : screened) {
    if (alike(result) <= 0) break;
    const Pose& here = result.place.registration.T_target_source;
    const auto near = [&](const Pose& U) { return same_placement(here, U, result.place.p_b, same_look_alike); };
    if (std::any_of(counted.begin(), counted.end(), near)) continue;
    counted.push_back(here);
    sum += alike(result);
  }
  return sum;
}

}  // namespace headframe
