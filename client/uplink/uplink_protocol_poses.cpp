// Updates of poses, in the order in which they and the keyframes were made, so that the server always sees a state of
// the session that the robot's SLAM had at some time.
#include <algorithm>

#include "client/uplink/uplink_protocol.hpp"
#include "common/wire/limits.hpp"
#include "common/wire/pose_message.hpp"

namespace headframe {
namespace {

constexpr std::size_t pose_bytes = 68;  // seven doubles with their tags, and the length

}  // namespace

void UplinkProtocol::on_poses_ack(std::uint64_t up_to, Events& events) {
  if (up_to > (carried_alone_ ? sent_update_ : source_.last_pose_update()))
    return end(events, ErrorCode::bad_input, "from the server: an ack of an update of poses that was not sent", false);
  durable_update_ = std::max(durable_update_, up_to);
  sent_update_ = std::max(sent_update_, durable_update_);
  events.emplace_back(PosesDurable{durable_update_});
}

/// Combines the next updates whose keyframes are all sent. Returns false if there is none.
bool UplinkProtocol::begin_poses(Events& events) {
  const std::uint64_t first = sent_update_ + 1;
  std::uint64_t last = sent_update_;
  while (last < source_.last_pose_update() && source_.keyframes_at_update(last + 1) <= sent_keyframes_) ++last;
  if (last < first) return false;
  auto poses = source_.poses(first, last);
  if (poses && poses->size() > limits::update_poses) poses = source_.poses(first, last = first);
  if (!poses) {
    end(events, poses.error().code, poses.error().message, true);  // without it, what follows would be at a wrong place
    return true;
  }
  pose_transfer_ = PoseTransfer{last, std::move(*poses), 0};
  return true;
}

/// Returns true if whatever follows has to wait.
bool UplinkProtocol::queue_poses(std::size_t chunk_bytes, Events& events) {
  if (!takes_poses_) return false;
  if (!pose_transfer_ && !begin_poses(events)) return false;
  if (ended() || chunk_bytes == 0) return true;
  PoseTransfer& open = *pose_transfer_;
  const std::size_t fits = std::clamp<std::size_t>(std::min(limits::chunk_bytes, chunk_bytes) / pose_bytes, 1,
                                                   open.poses.size() - open.offset);
  v1::RobotMessage message;
  *message.mutable_pose_update() =
      to_proto(open.number, open.poses.size(), open.offset, std::span(open.poses).subspan(open.offset, fits));
  queue(message);
  open.offset += fits;
  if (open.offset < open.poses.size()) return true;
  sent_update_ = open.number;
  pose_transfer_.reset();
  return true;
}

}  // namespace headframe
