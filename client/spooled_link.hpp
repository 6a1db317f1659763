#pragma once
// The spool, shared by two threads: the robot's adds to it, the uplink's sends from it and acknowledges.

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>

#include "client/progress.hpp"
#include "client/spool/spool.hpp"
#include "client/uplink/uplink_protocol.hpp"

namespace headframe {

/// Thread safe.
class SpooledLink final : public UplinkSource {
 public:
  explicit SpooledLink(Spool spool) : spool_(std::move(spool)) {}

  // Read by the uplink.
  std::uint64_t last_sequence() const override;
  Result<Keyframe> keyframe(std::uint64_t sequence) const override;
  std::uint64_t last_pose_update() const override;
  std::uint64_t keyframes_at_update(std::uint64_t number) const override;
  Result<std::vector<KeyframePose>> poses(std::uint64_t first, std::uint64_t last) const override;
  bool holds_cloud(std::uint64_t sequence) const override;
  std::uint64_t next_held_cloud(std::uint64_t from) const override;
  Result<std::string> cloud(std::uint64_t sequence) const override;
  std::optional<LiveState> live() const override;

  /// Applies an event of the uplink.
  void on_event(const UplinkEvent& event);

  /// Sets what the uplink reports of the robot from now on; a state without a pose leaves the pose unchanged. Nullopt:
  /// report nothing more.
  void say(const std::optional<LiveState>& state);
  void say_pose(double stamp_s, const Pose& T_local_sensor);

  Result<void> append(const Keyframe& keyframe, std::string_view encoded_cloud);
  Result<void> update_poses(std::vector<KeyframePose> poses);
  const Hello& identity() const { return spool_.identity(); }  // does not change
  const std::vector<std::string>& warnings() const { return spool_.warnings(); }

  void on_transform(const std::function<void(const Transforms&)>& callback);
  std::optional<Transforms> transforms() const;

  /// Sets the function that is called on the uplink's thread with every answer to where the robot is.
  void on_localization(const std::function<void(const Localization&)>& callback);

  // The same for every answer to what others know. That for a map is called once.
  void on_trajectories(const std::function<void(const Trajectories&)>& callback);
  void on_coverage(const std::function<void(const Coverage&)>& callback);
  void on_map(const std::function<void(const MapAround&)>& callback);

  Progress progress() const;  // without bytes_sent and connected

  /// Whether everything that the policy sends, and that the server supports, is acknowledged by the server of the
  /// present or last connection.
  bool all_acknowledged() const;

  /// Returns when something was acknowledged or a connection ended, or after the time.
  void wait(std::chrono::milliseconds most) const;

 private:
  void take(const Transforms& transforms);
  bool takes_poses() const;
  template <class Told>
  void hand_on(const Told& told, std::function<void(const Told&)> SpooledLink::*set);

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  Spool spool_;
  std::optional<LiveState> live_;
  bool welcomed_ = false;
  std::uint64_t durable_keyframes_ = 0;  // as last reported; a server may hold fewer than were acknowledged before
  std::uint64_t durable_update_ = 0;     // the same for updates of poses
  bool refused_ = false;
  std::uint64_t refused_clouds_ = 0;
  double server_bytes_per_s_ = 0;
  std::vector<std::string> server_capabilities_;
  std::string hold_, cut_, link_error_, cloud_error_;
  std::optional<Transforms> transforms_;
  std::function<void(const Transforms&)> on_transform_;
  std::function<void(const Localization&)> on_localization_;
  std::function<void(const Trajectories&)> on_trajectories_;
  std::function<void(const Coverage&)> on_coverage_;
  std::function<void(const MapAround&)> on_map_;
};

}  // namespace headframe
