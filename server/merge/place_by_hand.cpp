// The operator places one session on another, roughly. Registration converges only from a metre or so, so positions
// around the placement are tried too; the best of them competes with the placements that the search proposes.
#include <algorithm>
#include <numbers>

#include "server/merge/merge_pipeline.hpp"
#include "server/merge/merge_state.hpp"
#include "server/session/same_placement.hpp"

namespace headframe {
namespace {

/// How far a placement by hand may be off; a registration that ends farther away is another placement.
constexpr PlacementTolerance near_hand{5, 25 * std::numbers::pi / 180};
constexpr double step_m = 2, step_rad = 10 * std::numbers::pi / 180;  // between the positions that are tried

/// The placement itself, and copies moved and turned about p_b in every direction.
std::vector<Hypothesis> around(const Pose& T_a_b, const Eigen::Vector3d& p_b) {
  std::vector<Hypothesis> out;
  for (const double turn : {0, 1, -1})
    for (const double x : {0, 1, -1})
      for (const double y : {0, 1, -1}) {
        Pose T = T_a_b;
        T.linear() = pose_from_yaw(turn * step_rad, {0, 0, 0}).linear() * T_a_b.linear();
        T.translation() = T_a_b * p_b - T.linear() * p_b + step_m * Eigen::Vector3d(x, y, 0);
        out.push_back({.T_a_b = T, .place_b = p_b, .source = ProposalSource::hand});
      }
  return out;
}

/// The best verdict near the operator's placement; end(): none.
std::vector<Verdict>::iterator nearest_to_hand(std::vector<Verdict>& verdicts, const Pose& T_a_b) {
  return std::find_if(verdicts.begin(), verdicts.end(),
                      [&](const Verdict& v) { return same_placement(v.judgement.T_a_b, T_a_b, v.p_b, near_hand); });
}

}  // namespace

/// The verdict near the operator's placement comes first, however bad it is, then those of the search's proposals.
std::vector<Verdict> MergePipeline::State::judge_by_hand(const OrderedPair& pair, const Case& at,
                                                         const Attempt& attempt) {
  const Pose& T_a_b = at.hypothesis.T_a_b;
  std::vector<Case> cases;
  for (const Hypothesis& h : around(T_a_b, middle_of_overlap(at)))
    cases.push_back(requests.make_case(pair.a, pair.b, h, attempt.clouds));
  std::vector<Verdict> alone = verifier.judge_cases(pair, cases, true, attempt).judged;
  const auto best = nearest_to_hand(alone, T_a_b);
  if (best == alone.end())
    return {Verdict{verifier.judge_placement(pair, T_a_b, attempt.clouds), middle_of_overlap(at)}};
  cases.clear();
  cases.push_back(requests.make_case(
      pair.a, pair.b, {.T_a_b = best->judgement.T_a_b, .place_b = best->p_b, .source = ProposalSource::hand},
      attempt.clouds));
  finder.allow(static_cast<std::size_t>(config.searches));
  if (const Found* found = propose(pair, attempt.report))
    for (const Hypothesis& h : found->hypotheses)
      cases.push_back(requests.make_case(pair.a, pair.b, h, attempt.clouds));
  std::vector<Verdict> all = verifier.judge_cases(pair, cases, true, attempt).judged;
  if (nearest_to_hand(all, T_a_b) == all.end()) all.push_back(*best);
  const auto by_hand = nearest_to_hand(all, T_a_b);
  std::rotate(all.begin(), by_hand, by_hand + 1);
  return all;
}

Result<HandPlacement> MergePipeline::place(SessionId a, SessionId b, const Pose& T_a_b, CloudSource& clouds,
                                           AttemptReport& report) {
  State& s = *state_;
  for (const SessionId id : {a, b})
    if (!s.sessions.contains(id))
      return failure(ErrorCode::not_found,
                     "there is no session " + std::to_string(id) + ", or it is left out of merging");
  if (a == b) return failure(ErrorCode::invalid_argument, "a session lies on itself where it is");
  if (a > b) return place(b, a, T_a_b.inverse(), clouds, report);
  const Alignment* known = s.book.find(a, b);
  if (known && (known->state == AlignmentState::published || known->ruling == Ruling::confirmed))
    return failure(ErrorCode::refused, "the two are merged, by alignment " + std::to_string(known->id) +
                                           ": retract it first if they lie elsewhere");
  const Attempt attempt{clouds, report};
  const OrderedPair pair = s.sessions.ordered(a, b);
  clouds.working_on(a, b);
  const Case at =
      s.requests.make_case(pair.a, pair.b, {.T_a_b = by_ids(pair, s.sessions.frames().local(a, b, T_a_b))}, clouds);
  if (at.a.stored.empty() || at.b.stored.empty()) {
    attempt.want(s.requests.clouds_for_contact(pair, at));
    if (report.wanted.empty())
      return failure(ErrorCode::refused,
                     "nobody has clouds where the two would meet: they lie too far apart there, or "
                     "the robots are away");
    return failure(ErrorCode::unavailable,
                   std::to_string(report.wanted.size()) +
                       " clouds were asked of the robots, for none are here where the two would "
                       "meet; place them again when they have come");
  }
  std::vector<Verdict> verdicts = s.judge_by_hand(pair, at, attempt);
  const bool fits = nearest_to_hand(verdicts, at.hypothesis.T_a_b) == verdicts.begin();
  const std::optional<Pose> T_rival = note_rival(verdicts);
  HandPlacement out = s.book.place(pair, verdicts.front().judgement, T_rival, fits, report);
  const Pose T_hand = by_ids(pair, at.hypothesis.T_a_b), T_now = out.alignment.T_a_b;
  const Eigen::Vector3d p = pair.a == a ? verdicts.front().p_b : at.hypothesis.T_a_b * verdicts.front().p_b;
  out.moved_m = (T_now * p - T_hand * p).norm();
  out.turned_rad = rotation_angle_rad(T_hand.inverse() * T_now);
  if (out.recorded) s.judged.forget(a, b);
  s.update_atlas(report);
  report = s.book.given_out(std::move(report));
  out.alignment = s.sessions.frames().given_out(out.alignment);
  return out;
}

}  // namespace headframe
