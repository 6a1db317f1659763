#include "server/merge/merge_pipeline.hpp"

#include <algorithm>
#include <set>

#include "server/merge/merge_state.hpp"
#include "server/session/same_placement.hpp"
#include "server/support/stopwatch.hpp"

namespace headframe {

// ---- One attempt to merge one session with others, on one page (FRAME, section on map merging; numbers of its steps)

AttemptReport MergePipeline::attempt(SessionId id, CloudSource& clouds) {
  AttemptReport report;
  State& s = *state_;
  if (!s.sessions.contains(id)) return report;
  const Attempt attempt{clouds, report};
  s.finder.allow(static_cast<std::size_t>(s.config.searches));
  s.sessions.set_looked_at(id, true);
  report.whole = s.sessions.at(id).complete;
  const PairWork::During sharing(s.shared);
  const std::map<AlignmentId, Pose> before = s.book.published();
  s.merge_with_partners(id, attempt);
  s.settle_others(id, attempt);
  if (report.unfinished) s.sessions.set_looked_at(id, false);
  s.book.release_awaited(report);
  s.consistency.look_at_contacts(attempt);  // compares sessions that would come to lie on each other
  s.close_loops(id, attempt);
  s.shared.end(report.unfinished);
  s.update_atlas(report);                      // 9: maps merge one after another, and bend where they meet again
  for (const Alignment& k : report.changed) {  // it is published first; then its loops are closed, and it is settled
    if (k.state != AlignmentState::published) continue;
    const auto was = before.find(k.id);  // it may have been judged anew, and is as it was
    if (was != before.end() && same_placement(was->second, k.T_a_b, s.sessions.at(k.b).middle(), same_when_settled))
      continue;
    s.to_settle.insert({k.a, k.b});
    report.unfinished = true;
  }
  report.self_likeness = s.self.take_news();
  return s.book.given_out(std::move(report));
}

void MergePipeline::State::merge_pair(const OrderedPair& pair, const Attempt& attempt, Look look) {
  if (!sessions.worth_a_look(pair)) return;  // no result would be published yet; it is tried when there is more path
  attempt.clouds.working_on(pair.a, pair.b);
  Alignment* known = book.find(pair.a, pair.b);
  const bool in_force = known && (known->state == AlignmentState::published || known->ruling == Ruling::confirmed);
  if (in_force && !ended_since_judged(*known) && still_holds(pair, *known, attempt)) return;

  // 5, 6: where could b lie on a? Not one nearest pair, but everything that the descriptors and the wall maps propose.
  const auto elsewhere = found_elsewhere(pair, attempt);
  const Found* found = propose(pair, attempt.report, elsewhere);
  if (!found) return;
  // 7: the clouds around each hypothesis; missing ones are requested, for the likeliest first.
  Candidates candidates;
  {
    const Stopwatch watch(attempt.report.times.sampling_ms);
    candidates = requests.cases_with_clouds(pair, found->hypotheses, known, attempt);
  }
  if (judged.judged_on(pair, what_there_is(pair, *found, candidates.cases))) return;
  auto& trace = attempt.report.traces.emplace_back(PairTrace{std::min(pair.a, pair.b), std::max(pair.a, pair.b)});
  for (const Hypothesis& h : found->hypotheses) trace.proposed.push_back({by_ids(pair, h.T_a_b), h.source});

  // 8: registration, then what the paper lacks: evidence, and a runner-up.
  const bool known_so_far = elsewhere && candidates.cases.size() == found->hypotheses.size();
  Verdicts verdicts = judge_cases(pair, candidates.cases, known, known_so_far ? &*elsewhere : nullptr, attempt, look);
  std::vector<Verdict>& all = verdicts.judged;
  for (const Verdict& v : all) trace.judged.push_back(by_ids(pair, v.judgement));
  if (all.empty()) all.emplace_back();
  if (known) drop_ruled_out(pair, *known, all);
  if (all.empty()) return;  // the operator has ruled on all placements
  const std::optional<Pose> T_a_b_runner_up = note_rival(all);
  const Judgement& best = all.front().judgement;
  const bool waits = verifier.ask_for_more(pair, verdicts, candidates.awaited, attempt);
  if (waits) judged.forget(pair.a, pair.b);  // it is judged again even if the clouds do not come
  if (candidates.cases.empty() || (candidates.awaited > 0 && best.evidence.probability >= config.accept_probability))
    return;  // rivals of an acceptable placement are judged first
  book.record(pair, best, T_a_b_runner_up, waits, attempt.report);
}

/// Where a pair shares something, the right placement is nearly always among the first proposals: of 477 merges of made
/// and crossed drives it was beyond the second in 12, beyond the third in 7, and beyond the fourth in the same 7. The
/// others show copies and rivals.
Verdicts MergePipeline::State::judge_cases(const OrderedPair& pair, const std::vector<Case>& cases,
                                           const Alignment* known, const PairFindings* found_elsewhere,
                                           const Attempt& attempt, Look look) {
  constexpr std::size_t likeliest = 3;
  const bool ruled = known && known->ruling != Ruling::none;
  if (look == Look::at_the_likeliest_first && !book.live(pair.a, pair.b) && cases.size() > likeliest) {
    const std::vector<Case> first(cases.begin(), cases.begin() + likeliest);
    Verdicts verdicts = verifier.judge_cases(pair, first, ruled, attempt, found_elsewhere);
    if (std::none_of(verdicts.judged.begin(), verdicts.judged.end(), [this](const Verdict& v) {
          return v.judgement.evidence.probability_if_unique >= config.candidate_probability;
        }))
      return verdicts;
  }
  return verifier.judge_cases(pair, cases, ruled, attempt, found_elsewhere);
}

/// Tries all sessions of the site if they are few; of more, the most promising ones until enough came to nothing; and
/// all for which an alignment is known.
void MergePipeline::State::merge_with_partners(SessionId id, const Attempt& attempt) {
  const std::set<SessionId> aligned = book.aligned_with(id);
  std::set<SessionId> left = aligned;
  std::vector<SessionId> ranked = partners.rank(id, sessions);
  const int in_vain = config.most_in_vain(ranked.size());
  const bool many = in_vain < config.partners;
  if (many) ranked = most_promising(id, ranked, attempt.report);
  int came_to_nothing = 0;
  for (const SessionId other : ranked) {
    if (came_to_nothing >= in_vain && !aligned.contains(other)) continue;
    left.erase(other);
    const OrderedPair pair = sessions.ordered(id, other);
    if (shared.helpers_came()) announce(id, ranked, in_vain, attempt.clouds);
    merge_pair(pair, attempt, many ? Look::at_the_likeliest_first : Look::at_all);
    came_to_nothing += sessions.worth_a_look(pair) && !attempt.report.unfinished && !book.live(id, other);
  }
  for (const SessionId other : left)
    if (sessions.contains(other)) merge_pair(sessions.ordered(id, other), attempt);
}

/// While it is still being searched which these are, the few with the most votes.
std::vector<SessionId> MergePipeline::State::most_promising(SessionId id, std::vector<SessionId> ranked,
                                                            AttemptReport& report) {
  const Stopwatch watch(report.times.hypotheses_ms);
  if (auto chosen = promise.choose(id, ranked)) return *chosen;
  report.unfinished = true;
  if (ranked.size() > static_cast<std::size_t>(config.searches))
    ranked.resize(static_cast<std::size_t>(config.searches));
  return ranked;
}

/// Looks once more at recently published alignments of other sessions, until no clouds are requested for them: this
/// session may have released them, and no trigger will try them again.
void MergePipeline::State::settle_others(SessionId id, const Attempt& attempt) {
  std::erase_if(to_settle, [&](const std::pair<SessionId, SessionId>& both) {
    const auto [a, b] = both;
    const Alignment* known = book.find(a, b);
    const bool stands = known && known->state == AlignmentState::published;
    if (a == id || b == id || !stands || !sessions.contains(a) || !sessions.contains(b)) return true;
    const std::size_t asked = attempt.report.wanted.size();
    merge_pair(sessions.ordered(a, b), attempt);
    return attempt.report.wanted.size() == asked;
  });
}

/// Announces what this attempt will search, and then what those of sessions that wait for their turn will, so that
/// other servers may begin with it.
void MergePipeline::State::announce(SessionId id, const std::vector<SessionId>& ranked, int in_vain,
                                    const CloudSource& clouds) {
  constexpr std::size_t enough_later = 64;  // for a helper that is done before this attempt is
  std::vector<OrderedPair> later;
  for (const auto& [other, session] : sessions.all()) {
    if (later.size() >= enough_later) break;
    if (other == id || !session.complete || session.looked_at) continue;
    const auto others = partners.rank(other, sessions);
    const auto searches = searches_of(other, others, config.most_in_vain(others.size()), clouds);
    later.insert(later.end(), searches.begin(), searches.end());
  }
  shared.announce(searches_of(id, ranked, in_vain, clouds), later, clouds);
}

/// What an attempt of the session will search among these partners, and how the sessions look like themselves (a == b).
std::vector<OrderedPair> MergePipeline::State::searches_of(SessionId id, const std::vector<SessionId>& ranked,
                                                           int in_vain, const CloudSource& clouds) const {
  const std::set<SessionId> aligned = book.aligned_with(id);
  std::vector<OrderedPair> pairs;
  int tried = 0;
  for (const SessionId other : ranked) {
    if (tried >= in_vain && !aligned.contains(other)) continue;
    const OrderedPair pair = sessions.ordered(id, other);
    if (!sessions.worth_a_look(pair)) continue;
    tried += book.live(id, other) ? 0 : 1;
    const Session &a = sessions.at(pair.a), &b = sessions.at(pair.b);
    if (!finder.needs_search(PairSearch::view(pair.a, a), PairSearch::view(pair.b, b))) continue;
    for (const SessionId one : {id, other})
      if (!self.known(one, clouds)) pairs.push_back({one, one});
    pairs.push_back(pair);
  }
  return pairs;
}

std::optional<PairFindings> MergePipeline::State::found_elsewhere(const OrderedPair& pair, const Attempt& attempt) {
  const Stopwatch watch(attempt.report.times.hypotheses_ms);
  const Session &a = sessions.at(pair.a), &b = sessions.at(pair.b);
  if (!finder.may_search() || !finder.needs_search(PairSearch::view(pair.a, a), PairSearch::view(pair.b, b))) return {};
  return shared.findings(pair, attempt.clouds);
}

const Found* MergePipeline::State::propose(const OrderedPair& pair, AttemptReport& report,
                                           std::optional<PairFindings> known) {
  const Stopwatch watch(report.times.hypotheses_ms);
  const Session &a = sessions.at(pair.a), &b = sessions.at(pair.b);
  const SessionView of_a = PairSearch::view(pair.a, a), of_b = PairSearch::view(pair.b, b);
  const Found* found = known ? finder.take(of_a, of_b, std::move(known->hypotheses)) : finder.find(of_a, of_b);
  report.unfinished |= !found;  // the searches of one attempt are used up
  return found;
}

/// What the verdict depends on. It includes how many copies all sessions show: when that changes, the pair is judged
/// again.
JudgedOn MergePipeline::State::what_there_is(const OrderedPair& pair, const Found& found,
                                             const std::vector<Case>& cases) const {
  Evidence of_all;
  self.tell_of_mine(of_all);
  JudgedOn out{found.version,
               static_cast<int>(10 * looks_like_itself(of_all)),
               static_cast<int>(20 * std::min(0.5, of_all.mine_similar_places)),
               of_all.repetition >= copies_known,
               sessions.how_many_ended(pair),
               {}};
  for (const Case& c : cases) out.clouds.push_back(c.a.stored.size() + c.b.stored.size());
  return out;
}

/// Whether both sessions are complete, and at least one was not when the pair was last judged as a whole.
bool MergePipeline::State::ended_since_judged(const Alignment& known) const {
  const Session &a = sessions.at(known.a), &b = sessions.at(known.b);
  return a.complete && b.complete && a.path_m() + b.path_m() > known.evidence.path_m + 1e-3;
}

/// Judges a published alignment again with the keyframes that came since. Returns false if it no longer holds; one that
/// the operator confirmed always holds. When both sessions have ended, the clouds that settle it are requested; it
/// stays published meanwhile.
bool MergePipeline::State::still_holds(const OrderedPair& pair, Alignment& published, const Attempt& attempt) {
  const Pose T_0 = by_ids(pair, published.T_a_b);
  const Case now = requests.make_case(pair.a, pair.b, {.T_a_b = T_0}, attempt.clouds);
  if (now.a.stored.empty() || now.b.stored.empty()) return true;
  if (now.a.any_let_go || now.b.any_let_go) return true;  // clouds that supported it have been deleted
  const bool ended = sessions.have_ended(pair);
  if (ended) attempt.want(requests.clouds_to_settle(pair, now, published.evidence.spread_m));
  const JudgedOn at_its_placement{.complete = sessions.how_many_ended(pair),
                                  .clouds = {now.a.stored.size(), now.b.stored.size()}};
  if (judged.judged_on(pair, at_its_placement)) return true;
  const Stopwatch watch(attempt.report.times.verification_ms);
  Judgement again = verifier.judge_again(pair, now, attempt.clouds);
  Evidence& e = again.evidence;
  e.aliases = published.evidence.aliases;  // known only from the search of the whole pair
  e.look_alikes = published.evidence.look_alikes;
  e.similar_places = published.evidence.similar_places;
  e.mine_similar_places = published.evidence.mine_similar_places;
  e.farther_violation = published.evidence.farther_violation;
  e.farther_explained = published.evidence.farther_explained;
  e.rock_in_common = rock_as_dense(published.evidence, e);
  e.support = published.evidence.support;
  e.path_m = published.evidence.path_m;
  e.runner_up = published.evidence.runner_up;
  // Where the sessions around them say the same, copies elsewhere in the mine speak no more against it than when the
  // contact was recorded; it would be withdrawn and recorded again without end.
  if (consistency.known_contact({published.a, published.b, published.T_a_b}) != Contact::agrees) self.tell_of_mine(e);
  weigh(again);
  if (e.probability < config.candidate_probability) return published.ruling == Ruling::confirmed;
  const Eigen::Vector3d middle = now.b.stored[now.b.stored.size() / 2].p;
  if (e.probability >= config.accept_probability &&
      !same_placement(again.T_a_b, T_0, middle, ended ? same_when_settled : same_to_robots)) {
    again = by_ids(pair, again);
    published.T_a_b = again.T_a_b;
    published.evidence = again.evidence;
    published.changes = again.changes;
    attempt.report.changed.push_back(published);
  }
  return true;
}

void MergePipeline::State::drop_ruled_out(const OrderedPair& pair, const Alignment& known,
                                          std::vector<Verdict>& verdicts) const {
  std::erase_if(verdicts, [&](const Verdict& v) {
    const double seen_points = v.judgement.evidence.seen_points;
    return book.decisions().proposal(known.id, by_ids(pair, v.judgement.T_a_b), seen_points) == Proposal::suppressed;
  });
}

void MergePipeline::State::close_loops(SessionId id, const Attempt& attempt) {
  attempt.report.closures = closures.find(id, book.alignments(), attempt);
  for (const PairClosures& pair : attempt.report.closures) corrected.set(pair);
}

void MergePipeline::State::update_atlas(AttemptReport& report) {
  book.update_atlas(
      [&](SessionId a, SessionId b, const Pose& T_a_b) {
        return consistency.known_contact({a, b, T_a_b}).value_or(Contact::none);
      },
      [&](const auto& pair) { return consistency.objection(pair); }, report);
  corrected.update(book.atlas().components, book.alignments());
}

}  // namespace headframe
