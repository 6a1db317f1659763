#include "common/wire/pose_message.hpp"

#include "common/wire/convert.hpp"
#include "common/wire/limits.hpp"

namespace headframe {
namespace {

constexpr std::uint64_t most_number = 1'000'000'000'000'000;

}  // namespace

v1::PoseUpdate to_proto(std::uint64_t number, std::size_t total_poses, std::size_t offset,
                        std::span<const KeyframePose> poses) {
  v1::PoseUpdate m;
  m.set_number(number);
  m.set_total_poses(static_cast<std::uint32_t>(total_poses));
  m.set_offset(static_cast<std::uint32_t>(offset));
  v1::PoseRun* run = nullptr;
  std::uint64_t next = 0;
  for (const KeyframePose& pose : poses) {
    if (!run || pose.sequence != next) {
      run = m.add_runs();
      run->set_first(pose.sequence);
    }
    *run->add_t_local_sensor() = to_proto(pose.T_local_sensor);
    next = pose.sequence + 1;
  }
  return m;
}

Result<std::vector<KeyframePose>> poses_of(const v1::PoseUpdate& m) {
  std::vector<KeyframePose> poses;
  for (const v1::PoseRun& run : m.runs()) {
    std::uint64_t sequence = run.first();
    for (const v1::Pose& pose : run.t_local_sensor()) {
      const std::string name = "pose of keyframe " + std::to_string(sequence) + ": ";
      if (sequence == 0 || (!poses.empty() && sequence <= poses.back().sequence))
        return failure(ErrorCode::bad_input, name + "sequences start at 1 and rise");
      const auto T = from_proto(pose);
      if (!T) return failure(ErrorCode::bad_input, name + T.error().message);
      poses.push_back({sequence++, *T});
    }
  }
  return poses;
}

Result<PoseUpdatePart> from_proto(const v1::PoseUpdate& m) {
  const auto bad = [](const std::string& what) { return failure(ErrorCode::bad_input, what); };
  std::size_t count = 0;
  for (const v1::PoseRun& run : m.runs()) count += static_cast<std::size_t>(run.t_local_sensor_size());
  if (m.number() == 0 || m.number() > most_number) return bad("numbers go from 1 to 1e15");
  if (m.total_poses() == 0 || m.total_poses() > limits::update_poses)
    return bad(std::to_string(m.total_poses()) + " poses announced, 1 to " + std::to_string(limits::update_poses) +
               " are allowed");
  if (count == 0 || count > limits::part_poses)
    return bad(std::to_string(count) + " poses in one message, 1 to " + std::to_string(limits::part_poses) +
               " are allowed");
  if (m.offset() + count > m.total_poses()) return bad("more poses than were announced");
  auto poses = poses_of(m);
  if (!poses) return tl::unexpected(poses.error());
  return PoseUpdatePart{m.number(), m.total_poses(), m.offset(), std::move(*poses)};
}

}  // namespace headframe
