#include "server/net/pose_assembler.hpp"

#include <utility>

namespace headframe {

Result<std::optional<std::vector<KeyframePose>>> PoseAssembler::add(PoseUpdatePart part) {
  if (part.offset == 0) {
    *this = {};
    number_ = part.number;
    total_poses_ = part.total_poses;
  }
  const bool follows = part.number == number_ && part.total_poses == total_poses_ && part.offset == poses_.size() &&
                       (poses_.empty() || poses_.back().sequence < part.poses.front().sequence);
  if (!follows) {
    *this = {};
    return failure(ErrorCode::bad_input, "a part at pose " + std::to_string(part.offset) + " of " +
                                             std::to_string(part.total_poses) + " does not follow what came before it");
  }
  poses_.insert(poses_.end(), part.poses.begin(), part.poses.end());
  if (poses_.size() < total_poses_) return std::nullopt;
  return std::exchange(*this, {}).poses_;
}

}  // namespace headframe
