#pragma once
// The updates of keyframes' poses as the spool keeps them: one record each, for good, for a server that lost its
// database asks for all of them again.

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "client/spool/record_log.hpp"
#include "common/session/keyframe_pose.hpp"

namespace headframe {

/// Which records of session.log are updates. Not thread safe. Memory: 16 bytes an update.
class PoseLog {
 public:
  /// The next update is there, made when there were so many keyframes.
  void found(std::uint64_t at_byte, std::uint64_t keyframes) { updates_.push_back({at_byte, keyframes}); }
  void acknowledged(std::uint64_t number) { acknowledged_ = std::max(acknowledged_, std::min(number, last())); }

  std::uint64_t last() const { return updates_.size(); }  // updates are numbered from 1
  std::uint64_t acknowledged() const { return acknowledged_; }
  /// How many keyframes there were when it was made.
  std::uint64_t keyframes_at(std::uint64_t number) const { return updates_.at(number - 1).keyframes; }

  /// What the record of the next update holds. invalid_argument: a keyframe that is not among the first `keyframes`,
  /// one that is named twice, a pose that is none, none at all or more than limits::update_poses.
  Result<std::string> record_of(std::vector<KeyframePose> poses, std::uint64_t keyframes) const;
  /// What the updates from the first to the last say together, by rising sequence.
  Result<std::vector<KeyframePose>> read(const RecordLog& log, std::uint64_t first, std::uint64_t last) const;

 private:
  struct Update {
    std::uint64_t at_byte = 0, keyframes = 0;
  };
  std::vector<Update> updates_;
  std::uint64_t acknowledged_ = 0;
};

}  // namespace headframe
