#pragma once
// The updates of keyframe poses in the spool: one record each, kept for good, because a server that lost its database
// asks for all of them again.

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "client/spool/record_log.hpp"
#include "common/session/keyframe_pose.hpp"

namespace headframe {

/// Knows which records of session.log are updates. Not thread safe. Uses 16 bytes of memory for each update.
class PoseLog {
 public:
  /// Adds the next update, which was made when there were this many keyframes.
  void found(std::uint64_t at_byte, std::uint64_t keyframes) { updates_.push_back({at_byte, keyframes}); }
  void acknowledged(std::uint64_t number) { acknowledged_ = std::max(acknowledged_, std::min(number, last())); }

  std::uint64_t last() const { return updates_.size(); }  // updates are numbered from 1
  std::uint64_t acknowledged() const { return acknowledged_; }
  /// How many keyframes there were when the update was made.
  std::uint64_t keyframes_at(std::uint64_t number) const { return updates_.at(number - 1).keyframes; }

  /// The content of the next update's record. invalid_argument: a keyframe that is not among the first `keyframes` or
  /// that is named twice, an invalid pose, no poses, or more than limits::update_poses.
  Result<std::string> record_of(std::vector<KeyframePose> poses, std::uint64_t keyframes) const;
  /// The combined poses of the updates from first to last, by rising sequence.
  Result<std::vector<KeyframePose>> read(const RecordLog& log, std::uint64_t first, std::uint64_t last) const;

 private:
  struct Update {
    std::uint64_t at_byte = 0, keyframes = 0;
  };
  std::vector<Update> updates_;
  std::uint64_t acknowledged_ = 0;
};

}  // namespace headframe
