// Passes stored data to the pipeline, also at a start with an existing database. The operator and the robots see the
// last atlas at once; the pipeline then takes a while to read the keyframes of several years, and robots are served
// meanwhile.
#include <spdlog/spdlog.h>

#include "server/merge_worker/merge_worker.hpp"
#include "server/support/stopwatch.hpp"

namespace headframe {

Result<void> MergeWorker::restore() {
  auto sessions = store_.sessions();
  if (!sessions) return tl::unexpected(sessions.error());
  if (auto known = restore_troubles(); !known) return known;
  auto merge = store_.merge();
  if (!merge) return tl::unexpected(merge.error());
  DecisionBook decisions;
  decisions.restore(merge->decisions);
  decisions.rule(merge->alignments);
  stored_ = {std::move(*sessions), std::move(*merge)};
  for (const SessionRecord& session : stored_->sessions) {
    const auto trouble = troubles_.find(session.id);
    if (trouble != troubles_.end() && trouble->second.deleted) continue;
    known_[session.id].site = session.site;
    if (session.archived) archived_.insert(session.id);
  }
  for (const FrozenSession& frozen : stored_->merge.frozen) frozen_.insert(frozen.session);
  atlas_ = stored_->merge.atlas;
  update_view();
  const std::lock_guard lock(mutex_);
  busy_ = !stored_->sessions.empty();
  return {};
}

/// Passes the content of the store to the pipeline; on the worker's thread, before anything else.
void MergeWorker::bring_back() {
  if (!stored_) return;
  const auto start = Clock::now();
  std::uint64_t keyframes = 0;
  std::vector<SessionId> to_try;
  for (const SessionRecord& session : stored_->sessions) {
    if (watch_.stopped()) return;
    if (is_aside(session.id)) continue;
    bring_in(session);
    if (is_aside(session.id)) continue;  // by what came of it
    keyframes += known_[session.id].keyframes;
    if (!session.complete && !settled(session)) schedule_.grows(session.id, Clock::now());
    if (!has_to_be_tried(session)) continue;
    schedule_.trigger(session.id, Trigger::restart, Clock::now());
    to_try.push_back(session.id);
  }
  StoredMerge& merge = stored_->merge;
  pipeline_->restore_self_likeness(merge.self_likeness);
  pipeline_->restore_frozen(merge.frozen);
  for (const PairClosures& known : merge.closures) pipeline_->restore_closures(known);
  pipeline_->restore(std::move(merge.alignments), merge.atlas.revision, std::move(merge.decisions),
                     std::move(merge.anchors));
  const std::vector<SessionRecord> all = std::move(stored_->sessions);
  const std::size_t sessions = all.size();
  for (const SessionId session : to_try) pipeline_->await_attempt(session);
  stored_.reset();
  atlas_ = pipeline_->atlas();
  if (const auto provisional = changed_provisionals({}, atlas_); !provisional.empty())
    robots_->tell_provisional(atlas_, provisional);
  update_view();
  for (const SessionRecord& session : all) catch_up(session.id, session.complete);
  rest();
  constexpr double worth_a_line_s = 1;
  if (const double s = ms_since(start) / 1000; s > worth_a_line_s)
    spdlog::info("{} sessions with {} keyframes are back, {:.1f} s after the start", sessions, keyframes, s);
}

/// It had ended or paused and was tried as it is, so nothing is to be done until its robot drives on.
bool MergeWorker::settled(const SessionRecord& session) {
  return session.attempted_whole && known_[session.id].keyframes == session.attempted_keyframes;
}

/// No attempt has used all of its keyframes yet, or none since it ended.
bool MergeWorker::has_to_be_tried(const SessionRecord& session) {
  return session.complete ? !settled(session) : known_[session.id].keyframes > session.attempted_keyframes;
}

/// Passes a stored session to the pipeline. If it cannot be read, or takes too much, only this session suffers.
void MergeWorker::bring_in(const SessionRecord& session) {
  working_on(session.id, session.id);
  try {
    schedule_.belongs(session.id, session.key.robot);
    pipeline_->add_session(session.id, session.family, session.site);
    if (const auto waiting = read_patiently([&] { return store_.new_poses(session.id); }); !waiting)
      spdlog::error("new poses of session {} can not be read: {}", session.id, waiting.error().message);
    else if (waiting->number > 0)
      known_[session.id].feeds_up_to = waiting->keyframes;  // the stored alignments refer to the old poses
    feed(session.id, false);
    if (session.complete || settled(session)) pipeline_->complete_session(session.id);
    if (const auto clouds = read_patiently([&] { return store_.cloud_sequences(session.id); }); clouds)
      known_[session.id].stored = {clouds->begin(), clouds->end()};
    else
      spdlog::error("clouds of session {} can not be read: {}", session.id, clouds.error().message);
    if (const auto gone = read_patiently([&] { return store_.let_go(session.id); }); gone)
      known_[session.id].let_go = {gone->begin(), gone->end()};
    no_work();
  } catch (const std::exception& e) {
    spdlog::error("session {} can not be brought back: {}", session.id, e.what());
    no_work();
    blame({session.id, session.id, WorkMark::End::died});
    if (is_aside(session.id)) (void)pipeline_->set_aside(session.id);
  }
}

/// Passes keyframes that are stored and new to the pipeline. counts: whether distance and junctions trigger attempts.
void MergeWorker::feed(SessionId session, bool counts, std::uint64_t up_to) {
  Known& known = known_[session];
  if (known.feeds_up_to) up_to = std::min(up_to, *known.feeds_up_to);
  double metres = 0;
  bool junction = false;
  const auto give = [&](Keyframe keyframe) {
    if (keyframe.sequence > up_to) return;
    const Eigen::Vector3d here_m = keyframe.T_local_sensor.translation();
    const bool first = known.keyframes == 0;
    known.keyframes = keyframe.sequence;
    junction |= keyframe.descriptor.place_class == PlaceClass::junction;
    if (keyframe.point_count == 0) known.without_cloud.insert(keyframe.sequence);
    pipeline_->add_keyframe(session, std::move(keyframe));
    if (pipeline_->cut(session).from != 0) return;  // after a jump: the distance from the last keyframe was not driven
    if (!first) metres += (here_m - known.last_m).norm();
    known.last_m = here_m;
  };
  const auto read = read_patiently([&] { return store_.each_keyframe(session, known.keyframes + 1, give); });
  if (!read) spdlog::error("keyframes of session {} can not be read: {}", session, read.error().message);
  MergeView::Session& shown = draft_.sessions[session];
  shown.distance_m += metres;
  const SessionCut cut = pipeline_->cut(session);
  if (cut != known.cut) robots_->tell_cut(session, cut);
  known.cut = cut;
  if (counts) schedule_.travelled(session, metres, Clock::now());
  if (counts && junction) schedule_.junction(session, Clock::now());
}

}  // namespace headframe
