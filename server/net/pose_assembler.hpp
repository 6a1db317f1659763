#pragma once

#include <optional>
#include <vector>

#include "common/wire/pose_message.hpp"

namespace headframe {

/// Puts the messages of one update of poses together. Memory grows with the poses that came, never with the number that
/// was announced, up to limits::update_poses. Not thread safe.
class PoseAssembler {
 public:
  /// The whole update when this part was its last. bad_input: it does not follow what came before, which is forgotten.
  /// A part at offset 0 begins an update anew.
  Result<std::optional<std::vector<KeyframePose>>> add(PoseUpdatePart part);

 private:
  std::uint64_t number_ = 0;
  std::size_t total_poses_ = 0;
  std::vector<KeyframePose> poses_;
};

}  // namespace headframe
