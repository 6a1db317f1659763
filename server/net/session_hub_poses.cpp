// Where keyframes that came before lie now, as their robots say: stored first, then the merge worker hears of it.
#include "server/net/session_hub.hpp"

namespace headframe {

/// In the numbers of the session's parts. Under the lock.
PutPoses SessionHub::as_stored(SessionId session, const PosesReceived& event) const {
  PutPoses write{with_parts(session).front(), event.number, {}};
  for (const KeyframePose& pose : event.poses) {
    const KeyframeRef keyframe = stored_as(session, pose.sequence);
    PutPoses::OfSession& of = write.sessions[keyframe.session];
    of.poses.push_back({keyframe.sequence, pose.T_local_sensor});
  }
  for (auto& [id, of] : write.sessions) of.keyframes = event.keyframes - (sessions_.at(id).from - 1);
  return write;
}

void SessionHub::handle(SessionId session, const PosesReceived& event, const std::shared_ptr<RobotLink>& link,
                        std::size_t bytes) {
  if (over_quota(session, 0, link, bytes)) return;
  PutPoses put;
  {
    const std::lock_guard lock(mutex_);
    put = as_stored(session, event);
  }
  std::vector<SessionId> of;
  for (const auto& [id, poses] : put.sessions) of.push_back(id);
  const SessionId whole = put.session;
  write(std::move(put), link, bytes, [this, whole, of, number = event.number, to = std::weak_ptr(link)] {
    {
      const std::lock_guard lock(mutex_);
      std::uint64_t& newest = sessions_.at(whole).record.pose_update;
      newest = std::max(newest, number);
    }
    for (const SessionId id : of) news_.poses_durable(id);
    if (const auto robot = to.lock()) robot->poses_durable(number);
  });
}

/// What robots are told of its path and its clouds is told anew.
void SessionHub::tell_moved(SessionId session) {
  {
    const std::lock_guard lock(mutex_);
    ++sessions_.at(session).moves;
  }
  desk_.changed();
}

}  // namespace headframe
