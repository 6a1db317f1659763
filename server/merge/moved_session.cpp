// Handles a robot's SLAM moving earlier keyframes: the session is rebuilt, and its alignments are moved along.

#include <array>

#include "server/merge/alignment_edges.hpp"
#include "server/merge/merge_state.hpp"

namespace headframe {
namespace {

constexpr double least_m = 1e-6, least_rad = 1e-7;  // less is rounding of poses that were sent

/// The keyframes as the session would store them, in the local frame near zero.
std::vector<Keyframe> taken_in(SessionId id, const std::vector<Keyframe>& keyframes, SessionFrames& frames) {
  std::vector<Keyframe> out;
  out.reserve(keyframes.size());
  for (const Keyframe& keyframe : keyframes) out.push_back(frames.taken_in(id, keyframe, out));
  return out;
}

bool same_poses(const std::vector<Keyframe>& was, const std::vector<Keyframe>& now) {
  return std::equal(was.begin(), was.end(), now.begin(), now.end(), [](const Keyframe& k, const Keyframe& l) {
    const Pose T = k.T_local_sensor.inverse() * l.T_local_sensor;
    return T.translation().norm() < least_m && rotation_angle_rad(T) < least_rad;
  });
}

}  // namespace

void MergePipeline::State::forget_what_was_made_of(SessionId id) {
  to_prepare.erase(id);
  submaps.forget(id);
  finder.forget(id);
  promise.forget(id);
  self.forget(id);
  judged.forget(id);
  closures.forget(id);
  consistency.forget(id);
}

/// Moves the alignments before the old poses are forgotten, so that where two sessions meet, the keyframes keep their
/// place on the other session.
AttemptReport MergePipeline::move_session(SessionId id, const std::vector<Keyframe>& keyframes) {
  AttemptReport report;
  State& s = *state_;
  if (!s.sessions.contains(id) || s.sessions.frozen().contains(id)) return report;
  const Session was = s.sessions.at(id);
  SessionFrames frames;
  const std::vector<Keyframe> now = taken_in(id, keyframes, frames);
  const bool same_frame = frames.origin_m(id) == s.sessions.frames().origin_m(id);
  if (same_frame && same_poses(was.keyframes, now)) return report;

  const auto moved = s.book.moved(id, [&](const Alignment& of, const Pose& T_a_b) {
    const SessionId other = of.a == id ? of.b : of.a;
    const Session& met = s.sessions.contains(other) ? s.sessions.at(other) : was;  // where they meet is unknown
    const Pose T_met_was = &met == &was ? Pose::Identity() : of.a == id ? T_a_b.inverse() : T_a_b;
    const Pose T_was_now = T_was_now_where_they_meet(was, now, met, T_met_was);
    return of.a == id ? Pose(T_was_now.inverse() * T_a_b) : Pose(T_a_b * T_was_now);
  });
  s.forget_what_was_made_of(id);
  s.sessions.forget(id);
  s.sessions.add(id, was.family, was.site);
  for (const Keyframe& keyframe : keyframes) add_keyframe(id, keyframe);
  if (was.complete) complete_session(id);
  if (!was.awaited) s.sessions.await_no_more(id);
  s.sessions.set_asks_where(id, was.asks_where);
  for (const PairClosures& known : s.corrected.note_moved(id)) s.closures.restore(known);
  report.changed = moved.alignments;
  report.decided = moved.decisions;
  s.update_atlas(report);
  if (!report.atlas_changed) s.book.next_revision(report);
  return s.book.given_out(std::move(report));
}

}  // namespace headframe
