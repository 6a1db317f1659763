#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "headframe/v1/robot.pb.h"
#include "server/net/robot_events.hpp"
#include "server/net/transform_pages.hpp"

namespace headframe {

/// What there is to tell a robot that has not been told yet. Not a queue but a place for each kind of message, where
/// the newest word replaces or joins the older: acknowledgements are cumulative, only the latest transform counts. So
/// it is bounded by the session itself however slow the robot reads. Not thread safe.
class RobotOutbox {
 public:
  void welcome(Durable durable, int spares) { welcome_.emplace(std::move(durable), spares); }
  void acknowledge_keyframes(std::uint64_t durable) { keyframe_ack_ = durable; }
  void acknowledge_poses(std::uint64_t update) { pose_ack_ = std::max(pose_ack_.value_or(0), update); }
  void acknowledge_cloud(std::uint64_t sequence) { cloud_acks_.insert(sequence); }
  void refuse_cloud(std::uint64_t sequence, const std::string& reason);
  void request_submap(const std::vector<std::uint64_t>& sequences);
  /// Shared by all robots of the component.
  void update_transform(std::shared_ptr<const TransformPages> pages) {
    transform_ = std::move(pages);
    next_page_ = 0;
  }
  /// A serialised ServerMessage.
  void localization(std::shared_ptr<const std::string> payload) { localization_ = std::move(payload); }
  /// The same.
  void surroundings(SurroundingsKind kind, std::shared_ptr<const std::string> payload) {
    surroundings_[kind] = std::move(payload);
  }
  void policy(LinkPolicy policy) { policy_ = std::move(policy); }
  void ping(std::uint64_t nonce) { ping_ = nonce; }
  void pong(std::uint64_t nonce) { pong_ = nonce; }
  void error(v1::ErrorKind kind, const std::string& message, bool permanent);

  /// All of it as frames, most urgent first, but for transforms that come in pages one page at a time, so that the next
  /// acknowledgement waits for one at most; what others know around the robot goes one by one, when there is nothing
  /// else. Empty when there is nothing.
  std::string take();

 private:
  void append_welcome(std::string& out);
  void append_lists(std::string& out);

  std::optional<std::pair<Durable, int>> welcome_;  // with the spares that the robot may have
  std::optional<std::uint64_t> keyframe_ack_, pose_ack_, ping_, pong_;
  std::set<std::uint64_t> cloud_acks_;
  std::map<std::uint64_t, std::string> cloud_refusals_;
  std::vector<std::uint64_t> submap_;                // nearest to the sphere's centre first
  std::shared_ptr<const TransformPages> transform_;  // from next_page_ on
  std::size_t next_page_ = 0;
  std::shared_ptr<const std::string> localization_;
  std::map<SurroundingsKind, std::shared_ptr<const std::string>> surroundings_;
  std::optional<LinkPolicy> policy_;
  std::optional<v1::ErrorReport> error_;
};

}  // namespace headframe
