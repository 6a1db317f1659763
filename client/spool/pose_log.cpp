#include "client/spool/pose_log.hpp"

#include <algorithm>
#include <map>

#include "common/wire/limits.hpp"
#include "common/wire/pose_message.hpp"

namespace headframe {

Result<std::string> PoseLog::record_of(std::vector<KeyframePose> poses, std::uint64_t keyframes) const {
  const auto wrong = [](const std::string& what) { return failure(ErrorCode::invalid_argument, what); };
  if (poses.empty() || poses.size() > limits::update_poses)
    return wrong(std::to_string(poses.size()) + " poses, an update has 1 to " + std::to_string(limits::update_poses));
  std::sort(poses.begin(), poses.end(), [](const auto& k, const auto& l) { return k.sequence < l.sequence; });
  if (poses.back().sequence > keyframes)
    return wrong("there is no keyframe " + std::to_string(poses.back().sequence) + " yet");
  const v1::PoseUpdate message = to_proto(last() + 1, poses.size(), 0, poses);
  if (const auto sound = poses_of(message); !sound) return wrong(sound.error().message);
  return message.SerializeAsString();
}

Result<std::vector<KeyframePose>> PoseLog::read(const RecordLog& log, std::uint64_t first, std::uint64_t last) const {
  std::map<std::uint64_t, Pose> newest;
  for (std::uint64_t number = first; number <= last; ++number) {
    const auto bytes = log.read(updates_.at(number - 1).at_byte);
    if (!bytes) return tl::unexpected(bytes.error());
    v1::PoseUpdate message;
    const auto poses = message.ParseFromString(*bytes)
                           ? poses_of(message)
                           : failure(ErrorCode::bad_input, "session.log: an update of poses is unreadable");
    if (!poses) return tl::unexpected(poses.error());
    for (const KeyframePose& pose : *poses) newest[pose.sequence] = pose.T_local_sensor;
  }
  std::vector<KeyframePose> out;
  out.reserve(newest.size());
  for (const auto& [sequence, T] : newest) out.push_back({sequence, T});
  return out;
}

}  // namespace headframe
