#include "server/merge/candidate_verifier.hpp"

#include <algorithm>
#include <utility>

#include "server/merge/like_places.hpp"
#include "server/session/same_placement.hpp"
#include "server/support/stopwatch.hpp"

namespace headframe {
namespace {

// Promising placements of a pair that are judged with all evidence; more of them while none of those is likely. With
// the second limit two more of 64 pairs merge (tests/bench/README.md); the 95th percentile of an attempt's time rose
// from 350 to 567 ms.
constexpr std::size_t judged_closely = 4, judged_in_doubt = 10;
constexpr double likely = 0.3;  // probability_if_unique; set by hand

/// Below this shared path, in metres, a placement is looked at farther off before it is accepted. With clouds on
/// request one of a cave, over 9 m, was accepted at once; all clouds contradict it.
constexpr double short_path_m = 15;

/// Sets the descriptors' part of the evidence; spots where the mine has changed are left out.
void compare_descriptors(const DescriptorAgreement& agreement, Judgement& judgement) {
  constexpr double look_m = 15;  // range that a keyframe mostly describes
  std::vector<Unlike> changed;
  for (const Change& change : judgement.changes) changed.push_back({change.p_a, look_m + change.length_m / 2});
  const Agreement found = agreement.at(judgement.T_a_b, Heights::as_placed, changed);
  judgement.evidence.descriptors_compared = found.count;
  judgement.evidence.descriptors_alike = found.mean();
}

/// The probability that the placement would have if all that is not known yet supported it.
double most_probable(const ScreeningResult& screened, const Case& c, const DescriptorAgreement& agreement,
                     const JudgeConfig& config) {
  Judgement best{RegistrationStatus::converged, screened.place.registration.T_target_source, ideal_evidence()};
  compare_descriptors(agreement, best);
  measure_overlap(best.evidence, c.a.stored, c.b.stored, best.T_a_b, config);
  best.evidence.support = c.hypothesis.score;
  return best_probability(screened, best.evidence);
}

template <class Judged>
bool judged_enough(const std::vector<Judged>& all) {
  if (all.size() < judged_closely) return false;
  return all.size() >= judged_in_doubt || std::any_of(all.begin(), all.end(), [](const Judged& one) {
           return one.verdict.judgement.evidence.probability_if_unique >= likely;
         });
}

/// Whether a rival of at most this probability could neither beat the judged placement nor cast doubt on it.
bool hopeless_rival(double most_probable, const Verdict& judged) {
  constexpr double doubt = 0.1;  // share of the odds at which two placements count as indistinguishable
  Evidence e = judged.judgement.evidence;
  e.runner_up = most_probable;
  return runner_up_share(e) < doubt;
}

/// Sorts screening results: fewer contradictions, more inliers, and descriptors that agree along the path are better. A
/// single place of a mine that repeats itself fits at many others. The descriptors of one keyframe decide nothing: of a
/// right placement over 44 m, whose paths lay over 3 m apart but for one keyframe, that one was similar to .09.
double promise(const ScreeningResult& screened, const DescriptorAgreement& agreement) {
  constexpr double more = 3;  // keyframes, as the verdict adds; with 1 that placement was not judged
  const Registration& r = screened.place.registration;
  const double alike = agreement.at(r.T_target_source).cautious(more);
  return std::max(0.0, r.inlier_fraction - 20 * screened.place.unexplained()) * alike * alike;
}

/// The promising placements, best first.
std::vector<std::size_t> by_promise(const std::vector<ScreeningResult>& screened,
                                    const DescriptorAgreement& agreement) {
  std::vector<std::size_t> order;
  std::vector<double> promises(screened.size(), 0);
  for (std::size_t i = 0; i < screened.size(); ++i) {
    if (!screened[i].hopeful) continue;
    order.push_back(i);
    promises[i] = promise(screened[i], agreement);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return promises[i] > promises[j]; });
  return order;
}

/// Of the first cases of those that were screened.
std::vector<ScreeningResult> as_screened(std::size_t cases, const std::vector<HopefulCase>& hopeful) {
  std::vector<ScreeningResult> out(cases);
  for (const HopefulCase& one : hopeful)
    if (one.hypothesis < cases) out[one.hypothesis] = {true, one.place, nullptr, nullptr};
  return out;
}

}  // namespace

std::optional<Pose> note_rival(std::vector<Verdict>& verdicts) {
  Judgement& first = verdicts.front().judgement;
  std::optional<Pose> T_rival;
  for (const Verdict& v : verdicts) {
    if (same_placement(v.judgement.T_a_b, first.T_a_b, v.p_b, same_as_rival)) continue;
    const double probability = v.judgement.evidence.probability;
    if (T_rival && probability <= first.evidence.runner_up) continue;
    first.evidence.runner_up = probability;
    T_rival = v.judgement.T_a_b;
  }
  return T_rival;
}

Verdicts CandidateVerifier::judge_cases(const OrderedPair& pair, const std::vector<Case>& cases, bool all,
                                        const Attempt& attempt, const PairFindings* known) {
  for (const SessionId id : {pair.a, pair.b}) (void)self_.of(id, attempt.clouds);
  std::vector<ScreeningResult> screened;
  {
    const Stopwatch watch(attempt.report.times.registration_ms);
    screened =
        known ? as_screened(cases.size(), known->hopeful) : screen(pair, cases, submaps_, attempt.clouds, judge_);
  }
  const Stopwatch watch(attempt.report.times.verification_ms);
  for (const ScreeningResult& result : screened)
    if (result.hopeful && !attempt.report.traces.empty())
      attempt.report.traces.back().screened.push_back(by_ids(pair, result.place.registration.T_target_source));
  const std::vector<Judged> judged = judge_hopeful(pair, cases, screened, all, attempt.clouds, known);
  std::vector<Verdict> verdicts;
  for (const Judged& one : judged) {
    verdicts.push_back(one.verdict);
    weigh_among(judged, pair, cases[one.of], verdicts.back(), attempt.clouds);
  }
  std::stable_sort(verdicts.begin(), verdicts.end(), [](const Verdict& v, const Verdict& w) {
    return v.judgement.evidence.probability > w.judgement.evidence.probability;
  });
  return {std::move(verdicts), clouds_for_another_look(pair, cases, screened)};
}

/// Judges each placement on its own, as if the mine held no copies.
std::vector<CandidateVerifier::Judged> CandidateVerifier::judge_hopeful(const OrderedPair& pair,
                                                                        const std::vector<Case>& cases,
                                                                        const std::vector<ScreeningResult>& screened,
                                                                        bool all, CloudSource& clouds,
                                                                        const PairFindings* known) {
  const DescriptorAgreement agreement = sessions_.descriptor_agreement(pair);
  std::vector<Judged> out;
  for (const std::size_t i : by_promise(screened, agreement)) {
    if (judged_enough(out)) break;
    const SubmapCheck& place = screened[i].place;
    const double most = all ? 1 : most_probable(screened[i], cases[i], agreement, judge_);
    if (!out.empty() && most < config_.candidate_probability) continue;  // the first is judged so that it can be shown
    const bool spared = std::any_of(out.begin(), out.end(), [&](const Judged& other) {
      return same_placement(other.verdict.judgement.T_a_b, place.registration.T_target_source, place.p_b,
                            same_registration) ||
             (!all && hopeless_rival(most, other.verdict));
    });
    if (spared) continue;
    const Case& c = cases[i];
    const Judgement* elsewhere = nullptr;
    for (const JudgedCase& one : known ? std::span(known->judged) : std::span<const JudgedCase>())
      if (one.hypothesis == i) elsewhere = &one.judgement;
    const Judgement alone = elsewhere ? *elsewhere : judge_alone(pair, c, screened[i], clouds);
    Verdict verdict{alone, place.p_b};
    Evidence& e = verdict.judgement.evidence;
    e.support = c.hypothesis.score;
    compare_descriptors(agreement, verdict.judgement);
    const Pose& T = verdict.judgement.T_a_b;
    compare_with_itself(pair, c, T, e);
    e.look_alikes += count_alike(screened, T, likeness);
    e.similar_places += count_alike(screened, T, resemblance);
    tell_similar_places(pair, e);
    const double aliases = std::exchange(e.aliases, 0);  // they weigh together with the other placements
    weigh(verdict.judgement);
    e.aliases = aliases;
    out.push_back({std::move(verdict), i, alone});
  }
  return out;
}

void CandidateVerifier::compare_with_itself(const OrderedPair& pair, const Case& c, const Pose& T_a_b,
                                            Evidence& e) const {
  const Overlapping where = overlapping(c.a.stored, c.b.stored, T_a_b, judge_);
  const SelfLikeness a = likeness_at(self_.last(pair.a), where.a), b = likeness_at(self_.last(pair.b), where.b);
  e.aliases = a.aliases + b.aliases;
  e.look_alikes = a.look_alikes + b.look_alikes;
  e.similar_places = self_.last(pair.a).similar_places + self_.last(pair.b).similar_places;
  self_.tell_of_mine(e);
  e.mine_look_alikes = expected_look_alikes(e.mine_look_alikes, a, b, e);
  tell_similar_places(pair, e);
}

/// Raises Evidence::mine_similar_places to what the two sessions show.
void CandidateVerifier::tell_similar_places(const OrderedPair& pair, Evidence& e) const {
  const double of_both_m = searched_m(self_.last(pair.a)) + searched_m(self_.last(pair.b));
  e.mine_similar_places = std::max(e.mine_similar_places, per_100_m(e.similar_places, of_both_m, well_known_m));
}

Judgement CandidateVerifier::judge_alone(const OrderedPair& pair, const Case& c, const ScreeningResult& screened,
                                         CloudSource& clouds) {
  ScreeningResult first = screened;
  if (!first.a) {  // it was screened elsewhere
    const SubmapPair at = place_screened(pair, c, screened.place, submaps_, clouds, judge_);
    if (!at.a) return {};  // no place of this case is there: what the other server found is of no use
    first.a = at.a;
    first.b = at.b;
  }
  return judge(submaps_.scene(pair, c.a.stored, c.b.stored, clouds), first, judge_);
}

std::vector<JudgedCase> CandidateVerifier::judge_ahead(const OrderedPair& pair, const std::vector<Case>& cases,
                                                       const std::vector<ScreeningResult>& screened,
                                                       CloudSource& clouds) {
  std::vector<JudgedCase> out;
  for (Judged& one : judge_hopeful(pair, cases, screened, false, clouds, nullptr))
    out.push_back({one.of, std::move(one.alone)});
  return out;
}

/// Adds what is seen farther off. Returns the clouds that would show more of it.
std::set<KeyframeRef> CandidateVerifier::look_farther(const OrderedPair& pair, const Case& c, Verdict& verdict,
                                                      CloudSource& clouds) {
  LongRange far = check_long_range(pair, c, verdict.judgement, verdict.p_b, sessions_, submaps_, clouds, judge_);
  far.tell(verdict.judgement.evidence);
  weigh(verdict.judgement);
  return std::move(far.wanted);
}

/// Adds the other placements as aliases; a placement that may be right is looked at farther off. Unless it could be
/// accepted, and the mine repeats itself, hardly any path is shared, or nothing but rock is lacking that no nearer
/// cloud shows, that is done with the stored clouds.
void CandidateVerifier::weigh_among(const std::vector<Judged>& all, const OrderedPair& pair, const Case& c,
                                    Verdict& verdict, CloudSource& clouds) {
  Evidence& e = verdict.judgement.evidence;
  for (const Judged& other : all)
    if (const Judgement& rival = other.verdict.judgement;
        !same_placement(rival.T_a_b, verdict.judgement.T_a_b, verdict.p_b, same_registration))
      e.aliases += alias_of(e, rival.evidence);
  weigh(verdict.judgement);
  const double most = probability_with_ample_rock(verdict.judgement);
  std::set<KeyframeRef> farther;
  if (most >= config_.candidate_probability) farther = look_farther(pair, c, verdict, clouds);
  if (most < config_.accept_probability) farther.clear();
  if (e.repetition >= copies_known || e.overlap_m < short_path_m) verdict.wanted.assign(farther.begin(), farther.end());
  if (e.probability >= std::max(beyond_doubt, config_.accept_probability)) return;
  const auto near = requests_.clouds_for_verdict(pair, c, verdict.judgement, verdict.p_b);
  verdict.wanted.insert(verdict.wanted.end(), near.begin(), near.end());
  const bool lacks_rock = e.probability < config_.accept_probability &&
                          probability_with_ample_rock(verdict.judgement) >= config_.accept_probability;
  if (lacks_rock && verdict.wanted.empty()) verdict.wanted.assign(farther.begin(), farther.end());
}

Judgement CandidateVerifier::judge_again(const OrderedPair& pair, const Case& at, CloudSource& clouds) {
  if (at.a.stored.empty() || at.b.stored.empty()) return {};
  Judgement out =
      headframe::judge_again(submaps_.scene(pair, at.a.stored, at.b.stored, clouds), at.hypothesis.T_a_b, judge_);
  compare_descriptors(sessions_.descriptor_agreement(pair), out);
  weigh(out);
  return out;
}

Judgement CandidateVerifier::judge_contact(const OrderedPair& pair, const Case& at, CloudSource& clouds) {
  Judgement out = judge_again(pair, at, clouds);
  Evidence known = out.evidence;
  compare_with_itself(pair, at, out.T_a_b, known);
  const double excused = excused_by_changes(known);
  out.evidence.freespace_explained *= excused;
  out.evidence.worst_place_explained *= excused;
  out.evidence.mine_similar_places = known.mine_similar_places;
  // It is not looked at farther off, and little path by itself agrees with nothing.
  out.evidence.rock_in_common = hardly_any_rock;
  weigh(out);
  return out;
}

double CandidateVerifier::violation_at(const OrderedPair& pair, const Case& at, CloudSource& clouds) const {
  const Scene scene = submaps_.scene(pair, at.a.stored, at.b.stored, clouds);
  return headframe::violation_at(scene, at.hypothesis.T_a_b, judge_);
}

Judgement CandidateVerifier::judge_placement(const OrderedPair& pair, const Pose& T_a_b, CloudSource& clouds) {
  const Case at = requests_.make_case(pair.a, pair.b, {.T_a_b = T_a_b}, clouds);
  if (at.a.stored.empty() || at.b.stored.empty()) return {};
  Judgement out = judge_again(pair, at, clouds);
  for (const SessionId id : {pair.a, pair.b}) (void)self_.of(id, clouds);
  compare_with_itself(pair, at, out.T_a_b, out.evidence);
  weigh(out);
  return out;
}

}  // namespace headframe
