#include "server/merge_pipeline.hpp"

#include <algorithm>
#include <cmath>

#include "server/merge_state.hpp"

namespace headframe {
namespace {

constexpr double news_m = 0.05, news_rad = 0.2 * std::numbers::pi / 180;  // smaller changes of a transform are not told
constexpr double awaited_news_m = 5;
constexpr double rival_m = 2, rival_rad = 0.17;  // nearer than this it is the same placement

}  // namespace

// ---- The page: one attempt to merge one session with all others (FRAME, section on map merging; numbers of its steps)

AttemptReport MergePipeline::attempt(SessionId id, CloudSource& clouds) {
  AttemptReport report;
  State& s = *state_;
  if (!s.sessions.contains(id)) return report;
  s.finder.allow(static_cast<std::size_t>(s.config.searches));
  for (const SessionId other : s.partners(id)) s.merge_pair(s.laid(id, other), clouds, report);
  s.look_at_contacts(clouds, report);  // what the others say of it, where their maps come to lie on each other
  s.update_atlas(report);              // 9: maps merge one after another
  return s.given_out(std::move(report));
}

void MergePipeline::State::merge_pair(const Laid& pair, CloudSource& clouds, AttemptReport& report) {
  const SessionId a = pair.a, b = pair.b;
  clouds.working_on(a, b);
  Alignment* known = find(a, b);
  const bool in_force = known && (known->state == AlignmentState::published || known->ruling == Ruling::confirmed);
  if (in_force && !ended_since_judged(*known) && still_holds(*known, clouds, report)) return;

  // 5, 6: where could b lie on a? Not one nearest pair, but all that the descriptors and the wall maps propose.
  const Found* found = nullptr;
  {
    const Stopwatch watch(report.times.hypotheses_ms);
    const Session &of_a = sessions[a], &of_b = sessions[b];
    found = finder.find({a, of_a.keyframes, of_a.complete}, {b, of_b.keyframes, of_b.complete},
                        [&] { return match_descriptors(of_a.keyframes, of_b.keyframes, config.threads); });
  }
  if (!found) {
    report.unfinished = true;  // enough searched for one attempt
    return;
  }
  // 7: the clouds around each; what is not here is asked for, the likeliest first.
  Candidates candidates;
  {
    const Stopwatch watch(report.times.sampling_ms);
    candidates = look_for_clouds(pair, found->hypotheses, known, clouds, report);
  }
  Evidence of_all;  // sessions: when more of them show copies, or fewer, the pair is judged again
  of_all.repetition = repetition();
  std::vector<std::size_t> judged_now{found->version, static_cast<std::size_t>(worth_clouds(pair)),
                                      static_cast<std::size_t>(asked_overlap_m(of_all) / 10),
                                      static_cast<std::size_t>(of_all.repetition >= copies_known),
                                      static_cast<std::size_t>(sessions[a].complete + sessions[b].complete)};
  for (const Case& c : candidates.cases) judged_now.push_back(c.a.stored.size() + c.b.stored.size());
  if (auto& before = judged_on[std::minmax(a, b)]; before == judged_now)
    return;
  else
    before = judged_now;

  // 8: registration, then what the paper lacks: evidence, and a runner-up.
  const bool ruled = known && known->ruling != Ruling::none;
  auto& trace = report.traces.emplace_back(PairTrace{std::min(a, b), std::max(a, b)});
  for (const Hypothesis& h : found->hypotheses) trace.proposed.push_back({by_ids(pair, h.T_a_b), h.source});
  std::vector<Verdict> verdicts = judge_cases(a, b, candidates.cases, clouds, ruled, report);
  for (const Verdict& v : verdicts) trace.judged.push_back(by_ids(pair, v.judgement));
  if (verdicts.empty()) verdicts.emplace_back();
  if (known)
    std::erase_if(verdicts, [&](const Verdict& v) {
      const Evidence& e = v.judgement.evidence;
      return decisions.proposal(known->id, by_ids(pair, v.judgement.T_a_b), e.seen_points) == Proposal::suppressed;
    });
  if (verdicts.empty()) return;  // the operator has ruled on all there is
  Judgement& best = verdicts.front().judgement;
  std::optional<Pose> T_a_b_runner_up;
  for (const Verdict& v : verdicts) {  // the more probable first
    if (T_a_b_runner_up || !differ(v.judgement.T_a_b, best.T_a_b, v.p_b, rival_m, rival_rad)) continue;
    best.evidence.runner_up = v.judgement.evidence.probability;
    T_a_b_runner_up = v.judgement.T_a_b;
  }
  const bool waits = ask_for_more(pair, verdicts, candidates.awaited, clouds, report);
  if (candidates.cases.empty() || (candidates.awaited > 0 && best.evidence.probability >= config.accept_probability))
    return;  // rivals of what would be accepted are looked at first
  record(pair, best, T_a_b_runner_up, waits, report);
}

/// A published alignment is looked at again with the keyframes that came since. False: it does not stand up any more;
/// one that the operator confirmed always does.
bool MergePipeline::State::still_holds(Alignment& published, CloudSource& clouds, AttemptReport& report) {
  // Missing clouds are not asked for: the merge stands, more may come in the background.
  const Laid pair = laid(published.a, published.b);
  const Pose T_0 = by_ids(pair, published.T_a_b);
  const Case now = make_case(pair.a, pair.b, {T_0, 0, {}}, clouds);
  if (now.a.stored.empty() || now.b.stored.empty()) return true;
  const std::vector<std::size_t> judged_now{now.a.stored.size(), now.b.stored.size()};
  if (auto& before = judged_on[{published.a, published.b}]; before == judged_now)
    return true;
  else
    before = judged_now;
  const Stopwatch watch(report.times.verification_ms);
  Judgement again =
      judge_again(scene(pair.a, now.a.stored, clouds), scene(pair.b, now.b.stored, clouds), T_0, judge_config());
  again.evidence.aliases = published.evidence.aliases;  // what only the search of the whole pair tells
  again.evidence.repetition = repetition();
  again.evidence.look_alikes = published.evidence.look_alikes;
  again.evidence.farther_violation = published.evidence.farther_violation;
  again.evidence.support = published.evidence.support;
  again.evidence.path_m = published.evidence.path_m;
  again.evidence.runner_up = published.evidence.runner_up;
  compare_descriptors({sessions[pair.a].keyframes, sessions[pair.b].keyframes}, again);
  weigh(again);
  if (again.evidence.probability < config.candidate_probability) return published.ruling == Ruling::confirmed;
  const Eigen::Vector3d middle = now.b.stored[now.b.stored.size() / 2].p;
  if (again.evidence.probability >= config.accept_probability && differ(again.T_a_b, T_0, middle, news_m, news_rad)) {
    again = by_ids(pair, again);
    published.T_a_b = again.T_a_b;
    published.evidence = again.evidence;
    report.changed.push_back(published);
  }
  return true;
}

/// waits: however probable, a candidate for now.
void MergePipeline::State::record(const Laid& pair, const Judgement& judged, const std::optional<Pose>& T_runner_up,
                                  bool waits, AttemptReport& report) {
  const auto [a, b] = std::minmax(pair.a, pair.b);
  Judgement best = by_ids(pair, judged);
  best.evidence.path_m = sessions[a].path_m() + sessions[b].path_m();
  best.evidence.awaited_m = path_awaited_m(pair, judged.T_a_b, judged.evidence.overlap_m);
  const std::optional<Pose> T_a_b_runner_up = T_runner_up ? std::optional(by_ids(pair, *T_runner_up)) : std::nullopt;
  const Evidence& e = best.evidence;
  Alignment* known = find(a, b);
  const bool stands = known && known->state == AlignmentState::published &&
                      !differ(best.T_a_b, known->T_a_b, sessions.at(b).middle(), rival_m, rival_rad);
  const bool told = stands || (worth_clouds(pair) && !waits && e.awaited_m <= 0);
  AlignmentState now = AlignmentState::rejected;
  if (convinces(e, config))
    now = told ? AlignmentState::verified : AlignmentState::candidate;
  else if (e.probability >= config.candidate_probability)
    now = AlignmentState::candidate;
  if (!known) {
    alignments.push_back({static_cast<AlignmentId>(alignments.size()) + 1, a, b, now, best.T_a_b, e, now, Ruling::none,
                          T_a_b_runner_up});
    report.changed.push_back(alignments.back());
    return;
  }
  // What the operator ruled on stays in sight until something turns up that could be published.
  if (known->ruling != Ruling::none && now != AlignmentState::verified) return;
  const bool refused_once = decisions.proposal(known->id, best.T_a_b, e.seen_points) == Proposal::as_candidate;
  if (refused_once && now == AlignmentState::verified) now = AlignmentState::candidate;
  known->verdict = now;
  if (known->state == AlignmentState::published && now != AlignmentState::verified) now = AlignmentState::retracted;
  if (known->state == AlignmentState::retracted && now == AlignmentState::rejected) now = AlignmentState::retracted;
  const bool news = known->state != now || differ(known->T_a_b, best.T_a_b, Eigen::Vector3d::Zero(), 1e-6, 1e-6) ||
                    std::abs(known->evidence.awaited_m - e.awaited_m) > awaited_news_m;
  known->state = now;
  known->T_a_b = best.T_a_b;
  known->T_a_b_runner_up = T_a_b_runner_up;
  known->evidence = e;
  known->ruling = decisions.ruling(*known);
  if (news) report.changed.push_back(*known);
}

void MergePipeline::State::update_atlas(AttemptReport& report) {
  const Stopwatch watch(report.times.atlas_ms);
  const MergeResult merged = merge([&](SessionId a, SessionId b, const Pose& T_a_b) {
    return known_contact({a, b, T_a_b}).value_or(Contact::none);
  });
  for (std::size_t i = 0; i < alignments.size(); ++i) {
    const auto objection = objection_of(merged.contradicted_by[i]);
    const bool news =
        alignments[i].state != merged.states[i] || alignments[i].objection.has_value() != objection.has_value();
    alignments[i].state = merged.states[i];
    alignments[i].objection = objection;
    if (news) report.changed.push_back(alignments[i]);
  }
  // The last word on an alignment is the one to be stored.
  std::map<AlignmentId, Alignment> last;
  for (const Alignment& alignment : report.changed) last[alignment.id] = alignment;
  report.changed.clear();
  for (auto& [id, alignment] : last) report.changed.push_back(*find(alignment.a, alignment.b));

  std::map<SessionId, std::pair<SessionId, Pose>> before;
  for (const Component& component : atlas.components)
    for (const Placement& p : component.placements) before[p.session] = {component.id, p.T_component_session};
  for (const Component& component : merged.components)
    for (const Placement& p : component.placements) {
      const auto was = before.find(p.session);
      const bool alone = was == before.end() && component.placements.size() == 1;  // a new session moves no transform
      if (alone) continue;
      report.atlas_changed |= was == before.end() || was->second.first != component.id ||
                              differ(was->second.second, p.T_component_session, Eigen::Vector3d::Zero(), 1e-6, 1e-6);
    }
  atlas.components = merged.components;
  if (report.atlas_changed) ++atlas.revision;
}

MergePipeline::MergePipeline(const MergeConfig& config) : state_(std::make_unique<State>(config)) {}
MergePipeline::~MergePipeline() = default;

void MergePipeline::add_session(SessionId id, const FamilyId& family) {
  if (!state_->sessions.contains(id)) state_->wake_alignments(id);
  state_->sessions[id].family = family;
}

AttemptReport MergePipeline::set_aside(SessionId id) {
  AttemptReport report;
  if (!state_->sessions.contains(id)) return report;
  state_->forget(id);
  state_->update_atlas(report);
  ++state_->atlas.revision;
  report.atlas_changed = true;
  return state_->given_out(std::move(report));
}

void MergePipeline::add_keyframe(SessionId id, Keyframe keyframe) {
  Session& session = state_->sessions[id];
  keyframe = state_->frames.taken_in(id, std::move(keyframe), session.keyframes);
  state_->index_keyframe(id, keyframe);
  session.complete = false;
  session.add(std::move(keyframe));
}

Judgement MergePipeline::judge_placement(SessionId a, SessionId b, const Pose& T_a_b, CloudSource& clouds) {
  State& s = *state_;
  const Laid pair = s.laid(a, b);
  Judgement judged = by_ids(pair, s.judge_placement(pair, by_ids(pair, s.frames.local(a, b, T_a_b)), clouds));
  judged.T_a_b = s.frames.given_out(a, b, judged.T_a_b);
  return judged;
}

bool MergePipeline::prepare_ahead(CloudSource& clouds) { return state_->prepare_ahead(clouds); }

void MergePipeline::prepare_cloud(const KeyframeRef& keyframe, CloudSource& clouds) {
  state_->prepared.get(keyframe, clouds);
}

void MergePipeline::complete_session(SessionId id) {
  Session& session = state_->sessions[id];
  session.complete = true;
  session.set_aside_odd();
}

Result<AttemptReport> MergePipeline::decide(AlignmentId id, Decision decision) {
  auto& alignments = state_->alignments;
  const auto found = std::find_if(alignments.begin(), alignments.end(), [&](const auto& k) { return k.id == id; });
  if (found == alignments.end())
    return failure(ErrorCode::not_found,
                   "there is no alignment " + std::to_string(id) + "; the atlas lists those there are");
  Alignment& alignment = *found;
  const auto record = state_->decisions.decide(alignment, decision);
  if (!record) return tl::unexpected(record.error());
  AttemptReport report;
  if (!*record) return report;
  report.decided.push_back(**record);
  if (const auto T_confirmed = state_->decisions.confirmed_at(id); T_confirmed && decision == Decision::undo)
    alignment.T_a_b = *T_confirmed;
  alignment.ruling = state_->decisions.ruling(alignment);
  alignment.state = decided_state(alignment);
  state_->judged_on.erase({alignment.a, alignment.b});
  report.changed.push_back(alignment);
  state_->update_atlas(report);
  return state_->given_out(std::move(report));
}

Result<AttemptReport> MergePipeline::anchor(SessionId id) {
  if (!state_->sessions.contains(id)) return failure(ErrorCode::not_found, "there is no session " + std::to_string(id));
  AttemptReport report;
  auto& anchors = state_->anchors;
  if (!anchors.empty() && anchors.back() == id) return report;
  std::erase(anchors, id);
  anchors.push_back(id);
  report.anchored = id;
  state_->update_atlas(report);
  return state_->given_out(std::move(report));
}

void MergePipeline::restore(std::vector<Alignment> alignments, std::uint64_t revision,
                            std::vector<DecisionRecord> decisions, std::vector<SessionId> anchors) {
  state_->anchors = std::move(anchors);
  state_->take_back(std::move(alignments), std::move(decisions));
  for (Alignment& alignment : state_->alignments) alignment.ruling = state_->decisions.ruling(alignment);
  AttemptReport ignored;
  state_->update_atlas(ignored);
  state_->atlas.revision = revision;
  state_->given_out({});
}

std::string MergePipeline::why_cut(SessionId id) const { return state_->frames.why_cut(id); }

const Atlas& MergePipeline::atlas() const { return state_->atlas_given_out; }
const std::vector<Alignment>& MergePipeline::alignments() const { return state_->alignments_given_out; }

}  // namespace headframe
