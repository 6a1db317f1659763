// Keyframes that a robot's SLAM moved. The new poses wait in the store until they are taken over here, together with
// the alignments that move, in one write; so the stored data is consistent whenever the server is killed.
#include <spdlog/spdlog.h>

#include "server/merge_worker/merge_worker.hpp"

namespace headframe {
namespace {

/// The keyframes up to `last`, which the pipeline has, with their new poses.
Result<std::vector<Keyframe>> keyframes_now(Store& store, SessionId session, std::uint64_t last,
                                            const std::vector<KeyframePose>& poses) {
  std::vector<Keyframe> keyframes;
  auto pose = poses.begin();
  const auto read = store.each_keyframe(session, 1, [&](Keyframe keyframe) {
    if (keyframe.sequence > last) return;
    while (pose != poses.end() && pose->sequence < keyframe.sequence) ++pose;
    if (pose != poses.end() && pose->sequence == keyframe.sequence) keyframe.T_local_sensor = pose->T_local_sensor;
    keyframes.push_back(std::move(keyframe));
  });
  if (!read) return tl::unexpected(read.error());
  return keyframes;
}

}  // namespace

/// Called before the pipeline gets keyframes that came after the new poses. Those of a frozen session wait until it is
/// thawed.
void MergeWorker::take_in_poses(SessionId session) {
  Known& known = known_[session];
  const auto waiting = read_patiently([&] { return store_.new_poses(session); });
  if (!waiting) return spdlog::error("new poses of session {} can not be read: {}", session, waiting.error().message);
  if (waiting->number == 0) return known.feeds_up_to.reset();
  known.feeds_up_to = waiting->keyframes;
  if (frozen_.contains(session)) {
    spdlog::warn("session {} is frozen: where its robot says that {} keyframes lie now counts when it is thawed",
                 session, waiting->poses.size());
    return;
  }
  const auto now = read_patiently([&] { return keyframes_now(store_, session, known.keyframes, waiting->poses); });
  if (!now) return spdlog::error("keyframes of session {} can not be read: {}", session, now.error().message);
  std::vector<Eigen::Vector3d> path;
  path.reserve(now->size());
  for (const Keyframe& keyframe : *now) path.push_back(position(keyframe));
  AttemptReport report;
  if (!tried("taking in new poses", [&] { report = pipeline_->move_session(session, *now); })) return;
  PutMerge write;
  write.moved = MovedPoses{session, waiting->number, {}};
  const bool later_ones = waiting->poses.back().sequence > known.keyframes;  // others may have read these meanwhile
  if (report.atlas_changed || later_ones) write.moved->poses = waiting->poses;
  if (!commit(std::move(write), report, nullptr)) return;
  known.feeds_up_to.reset();
  if (report.atlas_changed || later_ones) note_moved(session, path);
  if (!report.atlas_changed) return;  // nothing that merging uses has moved
  spdlog::info("session {}: its robot moved {} keyframes (update {}); revision {}", session, waiting->poses.size(),
               waiting->number, atlas_.revision);
  schedule_.trigger(session, Trigger::poses, Clock::now());
}

void MergeWorker::note_moved(SessionId session, const std::vector<Eigen::Vector3d>& path) {
  Known& known = known_[session];
  const SessionCut cut = pipeline_->cut(session);
  if (cut != known.cut) robots_->tell_cut(session, cut);
  known.cut = cut;
  const std::size_t count = cut.from == 0 ? path.size() : std::min<std::size_t>(path.size(), cut.from - 1);
  double metres = 0;
  for (std::size_t i = 1; i < count; ++i) metres += (path[i] - path[i - 1]).norm();
  draft_.sessions[session].distance_m = metres;
  if (count > 0) known.last_m = path[count - 1];
  robots_->tell_moved(session);
  update_view();
}

/// Takes over new poses of a session that the pipeline has just read with its old ones.
void MergeWorker::catch_up(SessionId session, bool complete) {
  if (!known_[session].feeds_up_to || is_aside(session)) return;
  take_in_poses(session);
  const std::uint64_t before = known_[session].keyframes;
  feed(session, true);
  if (known_[session].keyframes == before) return;
  complete ? pipeline_->complete_session(session) : schedule_.grows(session, Clock::now());
}

}  // namespace headframe
