// The calls to the pipeline apart from attempts.

#include "server/merge/merge_state.hpp"
#include "server/merge/frozen_places.hpp"

namespace headframe {

MergePipeline::State::State(const MergeConfig& c, PairHelpers* helpers)
    : config(c),
      sessions(c),
      partners(c),
      finder(finder_config(c)),
      promise(c, sessions, finder),
      submaps(c, sessions),
      requests(c, sessions),
      self(c, sessions, finder, submaps, requests),
      verifier(c, sessions, submaps, self, requests),
      search(c, sessions, finder, submaps, requests, self, verifier),
      shared(search, sessions, helpers),
      book(c, sessions),
      closures(sessions, submaps),
      corrected(sessions),
      consistency(c, sessions, requests, verifier, book) {
  self.ask_first([this](SessionId id, CloudSource& clouds) -> std::optional<SelfLikeness> {
    const auto found = shared.findings({id, id}, clouds);
    return found ? std::optional(found->itself) : std::nullopt;
  });
}

MergePipeline::MergePipeline(const MergeConfig& config, PairHelpers* helpers)
    : state_(std::make_unique<State>(config, helpers)) {}
MergePipeline::~MergePipeline() = default;

void MergePipeline::add_session(SessionId id, const FamilyId& family, const std::string& site) {
  if (state_->sessions.contains(id)) return;
  state_->sessions.add(id, family, site);
  (void)state_->book.wake(id);
}

void MergePipeline::add_keyframe(SessionId id, Keyframe keyframe) {
  const Keyframe& taken = state_->sessions.add_keyframe(id, std::move(keyframe));
  state_->partners.add(id, taken, state_->sessions);
  state_->to_prepare.insert(id);
}

bool MergePipeline::ask_where(SessionId id, bool asks) {
  if (!state_->sessions.contains(id)) return false;
  state_->sessions.set_asks_where(id, asks);
  return true;
}

SessionLocalization MergePipeline::localization(SessionId id) const {
  State& s = *state_;
  return localize(id, s.sessions, s.book, [&](SessionId a, SessionId b, const Pose& T_a_b) {
    return s.consistency.known_contact({a, b, T_a_b}).value_or(Contact::none);
  });
}

void MergePipeline::complete_session(SessionId id) {
  state_->sessions.complete(id);
  state_->to_prepare.insert(id);
}

void MergePipeline::await_no_more(SessionId id) { state_->sessions.await_no_more(id); }

AttemptReport MergePipeline::set_aside(SessionId id) {
  AttemptReport report;
  State& s = *state_;
  if (!s.sessions.contains(id)) return report;
  s.forget_what_was_made_of(id);
  s.sessions.forget(id);
  s.corrected.forget(id);
  s.update_atlas(report);
  s.book.next_revision(report);
  return s.book.given_out(std::move(report));
}

AttemptReport MergePipeline::come_back(SessionId id) {
  AttemptReport report;
  State& s = *state_;
  if (!s.sessions.contains(id)) return report;
  s.update_atlas(report);
  s.book.next_revision(report);
  return s.book.given_out(std::move(report));
}

AttemptReport MergePipeline::set_site(SessionId id, const std::string& site) {
  AttemptReport report;
  State& s = *state_;
  if (!s.sessions.contains(id) || s.sessions.at(id).site == site) return report;
  s.sessions.set_site(id, site);
  s.partners.take_to_site(id, s.sessions);
  s.judged.forget(id);
  report.changed = s.book.wake(id);
  s.update_atlas(report);
  return s.book.given_out(std::move(report));
}

Result<AttemptReport> MergePipeline::freeze(SessionId id) {
  State& s = *state_;
  if (!s.sessions.contains(id)) return failure(ErrorCode::not_found, "there is no session " + std::to_string(id));
  if (s.sessions.frozen().contains(id)) return failure(ErrorCode::refused, "the session is frozen already");
  if (s.sessions.at(id).keyframes.empty()) return failure(ErrorCode::refused, "the session has no keyframe yet");
  AttemptReport report;
  const Atlas& atlas = s.book.atlas_given_out();
  FrozenSession now = frozen_now(id, atlas, s.corrected.given_out(), s.sessions.frozen());
  const bool own_frame = std::none_of(atlas.components.begin(), atlas.components.end(), [&](const Component& c) {
    return placement_in(c, id) && s.sessions.frozen().contains(c.id);
  });
  report.frozen.push_back(now);
  s.sessions.freeze(std::move(now));
  if (own_frame && s.book.anchor(id).value_or(false)) report.anchored = id;
  s.update_atlas(report);
  return s.book.given_out(std::move(report));
}

Result<AttemptReport> MergePipeline::thaw(SessionId id) {
  State& s = *state_;
  if (!s.sessions.thaw(id)) return failure(ErrorCode::refused, "the session is not frozen");
  AttemptReport report;
  report.thawed = id;
  s.corrected.touch(id);
  s.update_atlas(report);
  return s.book.given_out(std::move(report));
}

void MergePipeline::restore_frozen(std::vector<FrozenSession> frozen) {
  for (FrozenSession& session : frozen) state_->sessions.freeze(std::move(session));
}

void MergePipeline::prepare_cloud(const KeyframeRef& keyframe, CloudSource& clouds) {
  state_->submaps.prepare_cloud(keyframe, clouds);
  if (state_->sessions.contains(keyframe.session)) state_->to_prepare.insert(keyframe.session);
}

bool MergePipeline::prepare_ahead(CloudSource& clouds) {
  State& s = *state_;
  while (!s.to_prepare.empty()) {
    const SessionId id = *s.to_prepare.begin();
    clouds.working_on(id, id);
    if (s.submaps.prepare_next(id, clouds)) return true;
    if ((s.sessions.may_merge(id) || s.sessions.at(id).asks_where) && !s.self.known(id, clouds)) {
      (void)s.self.of(id, clouds);
      return true;
    }
    s.to_prepare.erase(id);  // until there is news of it
  }
  return false;
}

Judgement MergePipeline::judge_placement(SessionId a, SessionId b, const Pose& T_a_b, CloudSource& clouds) {
  State& s = *state_;
  const SessionFrames& frames = s.sessions.frames();
  const OrderedPair pair = s.sessions.ordered(a, b);
  Judgement judged = by_ids(pair, s.verifier.judge_placement(pair, by_ids(pair, frames.local(a, b, T_a_b)), clouds));
  judged.T_a_b = frames.given_out(a, b, judged.T_a_b);
  return judged;
}

Result<AttemptReport> MergePipeline::decide(AlignmentId id, Decision decision) {
  State& s = *state_;
  AttemptReport report;
  if (auto done = s.book.decide(id, decision, report); !done) return tl::unexpected(done.error());
  if (report.decided.empty()) return report;
  const Alignment& alignment = *s.book.find(id);
  s.judged.forget(alignment.a, alignment.b);
  s.update_atlas(report);
  return s.book.given_out(std::move(report));
}

Result<AttemptReport> MergePipeline::anchor(SessionId id) {
  State& s = *state_;
  if (!s.sessions.contains(id)) return failure(ErrorCode::not_found, "there is no session " + std::to_string(id));
  AttemptReport report;
  const auto news = s.book.anchor(id);
  if (!news) return tl::unexpected(news.error());
  if (!*news) return report;
  report.anchored = id;
  s.update_atlas(report);
  return s.book.given_out(std::move(report));
}

void MergePipeline::restore_self_likeness(std::map<SessionId, SelfLikeness> known) {
  std::erase_if(known, [&](const auto& entry) { return !state_->sessions.contains(entry.first); });
  state_->self.restore(std::move(known));
}

void MergePipeline::restore(std::vector<Alignment> alignments, std::uint64_t revision,
                            std::vector<DecisionRecord> decisions, std::vector<SessionId> anchors) {
  State& s = *state_;
  s.book.restore(std::move(alignments), std::move(decisions), std::move(anchors));
  for (const auto& [id, session] : s.sessions.all()) {
    s.sessions.set_looked_at(id, true);  // it has ended and was tried, see await_attempt()
    s.submaps.leave_for_attempts(id);    // submaps of all sessions would not fit into memory
    if (s.self.last(id).path_m >= 0) s.to_prepare.erase(id);
  }
  AttemptReport ignored;
  s.update_atlas(ignored);
  s.book.set_revision(revision);
  s.book.given_out({});
}

void MergePipeline::await_attempt(SessionId id) {
  if (state_->sessions.contains(id)) state_->sessions.set_looked_at(id, false);
}

void MergePipeline::restore_closures(const PairClosures& known) {
  State& s = *state_;
  if (!s.sessions.contains(known.a) || !s.sessions.contains(known.b)) return;
  s.closures.restore(known);
  s.corrected.set(known);
}

SessionCut MergePipeline::cut(SessionId id) const { return state_->sessions.frames().cut(id); }

const Corrections& MergePipeline::corrections() const { return state_->corrected.given_out(); }
const Atlas& MergePipeline::atlas() const { return state_->book.atlas_given_out(); }
const std::vector<Alignment>& MergePipeline::alignments() const { return state_->book.alignments_given_out(); }

}  // namespace headframe
