#pragma once
// What a robot must not lose: its session's identity, keyframes, encoded clouds and received acknowledgements.
//
// A directory is one session:
//   lock                 held by the one process that uses the directory
//   session.log          records (record_log.hpp): the identity, then runs, keyframes, updates of their poses and
//                        acknowledgements as they came
//   clouds/0000000001    one record each; removed when acknowledged, or when the quota needs the room
// A cloud and then its keyframe are on the disk (fdatasync) when append() returns. Acknowledgements are not synced; one
// lost in a power cut is requested again. Poses and descriptors are never dropped. A run is a random number for each
// time the directory was opened: if a spool was copied, both copies may go on, and the server tells them apart by their
// runs.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "client/spool/cloud_folder.hpp"
#include "client/spool/pose_log.hpp"
#include "client/spool/record_log.hpp"
#include "common/result.hpp"
#include "common/wire/convert.hpp"

namespace headframe {

struct SpoolConfig {
  std::filesystem::path directory;                // created if missing
  std::uint64_t cloud_quota_bytes = 8ULL << 30U;  // oldest clouds go first
  bool sync = true;                               // false: survives a killed process, but not a power cut
};

/// Not thread safe. Uses about 16 bytes of memory for each keyframe and 50 for each held cloud.
class Spool {
 public:
  /// Opens the session in the directory, or starts one for `robot` (an empty session name and a spool_id of 0 are
  /// replaced by random ones). refused: another process uses it, or it belongs to another robot, session or family;
  /// unavailable: the disk failed; bad_input: it is damaged.
  static Result<Spool> open(const SpoolConfig& config, Hello robot);

  const Hello& identity() const { return identity_; }  // with the runs, the present one last
  bool resumed() const { return resumed_; }
  const std::vector<std::string>& warnings() const { return warnings_; }  // what open() found and repaired

  /// keyframe.sequence must be last_sequence() + 1; encoded_cloud may be empty. If the disk is full, the oldest clouds
  /// are dropped first, then this one (dropped_clouds()); only then it fails. On an error nothing was added.
  Result<void> append(const Keyframe& keyframe, std::string_view encoded_cloud);
  std::uint64_t last_sequence() const { return keyframe_at_.size(); }
  Result<Keyframe> keyframe(std::uint64_t sequence) const;

  /// Sets new poses of earlier keyframes, as one record, so that all or none of it is on the disk on return. keyframe()
  /// still returns what was appended. invalid_argument: like PoseLog::record_of(). If the disk is full, the oldest
  /// clouds are dropped.
  Result<void> update_poses(std::vector<KeyframePose> poses);
  const PoseLog& pose_updates() const { return poses_; }
  /// The combined poses of some updates; see PoseLog::read().
  Result<std::vector<KeyframePose>> poses(std::uint64_t first_update, std::uint64_t last_update) const {
    return poses_.read(log_, first_update, last_update);
  }

  /// Clouds that are held and not yet acknowledged, by sequence.
  bool holds_cloud(std::uint64_t sequence) const { return clouds_.holds(sequence); }
  std::uint64_t next_held_cloud(std::uint64_t from) const { return clouds_.next(from); }  // 0: none at or after `from`
  Result<std::string> cloud(std::uint64_t sequence) const { return clouds_.read(sequence); }

  /// Cumulative; smaller numbers have no effect.
  Result<void> acknowledge_keyframes(std::uint64_t up_to);
  Result<void> acknowledge_cloud(std::uint64_t sequence);
  Result<void> acknowledge_poses(std::uint64_t up_to_update);
  /// Call when the server has accepted this run.
  Result<void> run_welcomed();
  /// Drops a cloud that cannot be sent.
  void drop_cloud(std::uint64_t sequence);

  std::uint64_t acknowledged_keyframes() const { return acknowledged_keyframes_; }
  std::uint64_t acknowledged_clouds() const { return acknowledged_clouds_; }
  std::uint64_t held_clouds() const { return clouds_.count(); }
  std::uint64_t dropped_clouds() const { return dropped_clouds_; }

 private:
  Spool(SpoolConfig config, FileDescriptor lock, RecordLog log)
      : config_(std::move(config)),
        lock_(std::move(lock)),
        log_(std::move(log)),
        clouds_(config_.directory / "clouds", config_.sync) {}
  static Result<FileDescriptor> lock(const std::filesystem::path& directory);
  Result<void> settle_identity(Hello robot);
  Result<void> begin_run(const std::vector<std::uint64_t>& runs, std::uint64_t welcomed);
  void keep_cloud(std::uint64_t sequence, std::string_view bytes);
  bool make_room(std::uint64_t bytes);
  void keep_quota();
  void note_dropped(std::uint64_t sequence);

  SpoolConfig config_;
  FileDescriptor lock_;
  RecordLog log_;
  Hello identity_;
  bool resumed_ = false;
  std::vector<std::string> warnings_;
  std::vector<std::uint64_t> keyframe_at_;  // byte of each keyframe's record
  PoseLog poses_;
  CloudFolder clouds_;
  std::uint64_t acknowledged_keyframes_ = 0;
  std::uint64_t acknowledged_clouds_ = 0;
  std::uint64_t dropped_clouds_ = 0;
};

}  // namespace headframe
