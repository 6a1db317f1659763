#include "server/net/robot_outbox.hpp"

#include <algorithm>

#include "common/wire/capabilities.hpp"
#include "common/wire/frame_codec.hpp"

namespace headframe {
namespace {

constexpr std::size_t list_entries = 4096;  // of one message: 10 bytes each at most, well below limits::frame_bytes
constexpr std::size_t reason_bytes = 256;

void append(std::string& out, const v1::ServerMessage& message) {
  // Lists are cut and texts are short: a message of ours always fits a frame.
  (void)append_frame(out, message.SerializeAsString());
}

}  // namespace

void RobotOutbox::refuse_cloud(std::uint64_t sequence, const std::string& reason) {
  cloud_refusals_[sequence] = reason.substr(0, reason_bytes);
}

void RobotOutbox::request_submap(const std::vector<std::uint64_t>& sequences) {
  for (const std::uint64_t sequence : sequences)
    if (std::find(submap_.begin(), submap_.end(), sequence) == submap_.end()) submap_.push_back(sequence);
}

void RobotOutbox::error(v1::ErrorKind kind, const std::string& message, bool permanent) {
  if (error_) return;  // the first is the cause
  error_.emplace();
  error_->set_kind(kind);
  error_->set_message(message);
  error_->set_permanent(permanent);
}

void RobotOutbox::append_welcome(std::string& out) {
  v1::ServerMessage message;
  auto& welcome = *message.mutable_welcome();
  welcome.set_protocol_version(protocol_version);
  welcome.set_durable_keyframes(welcome_->first.keyframes);
  welcome.set_durable_pose_update(welcome_->first.pose_update);
  welcome.set_spares(static_cast<std::uint32_t>(welcome_->second));
  const auto capabilities = server_capabilities();
  *welcome.mutable_capabilities() = {capabilities.begin(), capabilities.end()};
  v1::SequenceRange* range = nullptr;
  for (const std::uint64_t sequence : welcome_->first.clouds) {
    if (!range || sequence != range->last() + 1) {
      // A robot that does not hear of the rest sends some clouds twice, which is harmless.
      if (welcome.durable_clouds_size() == static_cast<int>(list_entries)) break;
      range = welcome.add_durable_clouds();
      range->set_first(sequence);
    }
    range->set_last(sequence);
  }
  append(out, message);
  welcome_.reset();
}

void RobotOutbox::append_lists(std::string& out) {
  while (!cloud_acks_.empty()) {
    v1::ServerMessage message;
    auto& sequences = *message.mutable_cloud_ack()->mutable_sequences();
    while (!cloud_acks_.empty() && sequences.size() < static_cast<int>(list_entries))
      sequences.Add(cloud_acks_.extract(cloud_acks_.begin()).value());
    append(out, message);
  }
  for (const auto& [sequence, reason] : cloud_refusals_) {
    v1::ServerMessage message;
    message.mutable_cloud_refusal()->set_sequence(sequence);
    message.mutable_cloud_refusal()->set_reason(reason);
    append(out, message);
  }
  cloud_refusals_.clear();
  for (std::size_t i = 0; i < submap_.size(); i += list_entries) {
    v1::ServerMessage message;
    auto& sequences = *message.mutable_submap_request()->mutable_sequences();
    for (std::size_t j = i; j < std::min(i + list_entries, submap_.size()); ++j) sequences.Add(submap_[j]);
    append(out, message);
  }
  submap_.clear();
}

std::string RobotOutbox::take() {
  std::string out;
  v1::ServerMessage message;
  if (welcome_) append_welcome(out);
  if (policy_) {
    message.mutable_link_policy()->set_bytes_per_s(policy_->bytes_per_s);
    message.mutable_link_policy()->set_hold(policy_->hold);
    message.mutable_link_policy()->set_cut(policy_->cut);
    append(out, message);
  }
  if (keyframe_ack_) {
    message.mutable_keyframe_ack()->set_durable_keyframes(*keyframe_ack_);
    append(out, message);
  }
  if (pose_ack_) {
    message.mutable_pose_update_ack()->set_durable_pose_update(*pose_ack_);
    append(out, message);
  }
  append_lists(out);
  if (transform_) (void)append_frame(out, transform_->at(next_page_++));  // its maker saw that it fits
  if (localization_) (void)append_frame(out, *localization_);
  if (pong_) {
    message.mutable_pong()->set_nonce(*pong_);
    append(out, message);
  }
  if (ping_) {
    message.mutable_ping()->set_nonce(*ping_);
    append(out, message);
  }
  if (error_) {
    *message.mutable_error() = *error_;
    append(out, message);
  }
  if (out.empty() && !surroundings_.empty())
    (void)append_frame(out, *surroundings_.extract(surroundings_.begin()).mapped());
  policy_.reset();
  keyframe_ack_.reset();
  pose_ack_.reset();
  ping_.reset();
  pong_.reset();
  if (transform_ && next_page_ == transform_->size()) transform_.reset();
  localization_.reset();
  error_.reset();
  return out;
}

}  // namespace headframe
