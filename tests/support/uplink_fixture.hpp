#pragma once
// The robot's side of the protocol with a manual clock and a table for a spool.

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "client/uplink/uplink_protocol.hpp"
#include "common/wire/limits.hpp"

namespace headframe {

class Table : public UplinkSource {
 public:
  std::uint64_t keyframes = 0;
  std::map<std::uint64_t, std::string> clouds;
  std::optional<LiveState> state;
  std::optional<LiveState> live() const override { return state; }
  std::vector<std::pair<std::uint64_t, std::vector<std::uint64_t>>> updates;  // of poses: when, and of which keyframes
  bool damaged_poses = false;
  void move(std::uint64_t keyframes_then, const std::vector<std::uint64_t>& sequences) {
    updates.emplace_back(keyframes_then, sequences);
  }
  std::uint64_t last_pose_update() const override { return updates.size(); }
  std::uint64_t keyframes_at_update(std::uint64_t number) const override { return updates.at(number - 1).first; }
  Result<std::vector<KeyframePose>> poses(std::uint64_t first, std::uint64_t last) const override {
    if (damaged_poses) return failure(ErrorCode::bad_input, "damaged");
    std::set<std::uint64_t> all;
    for (auto i = first; i <= last; ++i) all.insert(updates.at(i - 1).second.begin(), updates.at(i - 1).second.end());
    std::vector<KeyframePose> out;
    out.reserve(all.size());
    for (const std::uint64_t sequence : all) out.push_back({sequence, Pose::Identity()});
    return out;
  }
  std::uint64_t last_sequence() const override { return keyframes; }
  Result<Keyframe> keyframe(std::uint64_t sequence) const override {
    Keyframe k;
    k.sequence = sequence;
    k.descriptor.q = {1};
    return k;
  }
  bool holds_cloud(std::uint64_t s) const override { return clouds.count(s) != 0; }
  std::uint64_t next_held_cloud(std::uint64_t from) const override {
    const auto it = clouds.lower_bound(from);
    return it == clouds.end() ? 0 : it->first;
  }
  Result<std::string> cloud(std::uint64_t s) const override {
    const auto it = clouds.find(s);
    if (it == clouds.end() || it->second == "damaged") return failure(ErrorCode::bad_input, "damaged");
    return it->second;
  }
};

inline Hello rover(CloudPolicy clouds) {
  return {{"rover", "s"}, {"os1", 32, 20, 20, 100}, {{"f", 1}, 1, 0}, clouds, "test", 9};
}

class UplinkProtocolTest : public testing::Test {
 protected:
  void start(CloudPolicy clouds = CloudPolicy::all) { link_.emplace(limits_, rover(clouds), table_, now_); }

  /// Everything it wants to send now, in words, those that go as one in one: "k3" keyframe, "c2:0" chunk of cloud 2 at
  /// KiB 0, "none2" unavailable, "u1:0/5" the part of update 1 of five poses that begins with the first.
  std::vector<std::string> sent(std::size_t most = 1000) {
    std::vector<std::string> words;
    while (words.size() < most) {
      const auto frame = link_->next_frame(now_, chunk_bytes_, events_);
      if (!frame) break;
      FrameReader reader;
      reader.feed(*frame);
      std::string together;
      for (auto payload = reader.next(); payload && *payload; payload = reader.next()) {
        v1::RobotMessage m;
        EXPECT_TRUE(m.ParseFromString(**payload));
        if (!together.empty()) together += ' ';
        together += word(m);
      }
      words.push_back(together);
    }
    return words;
  }

  std::string word(const v1::RobotMessage& m) {
    if (m.has_hello()) return m.hello().spare() ? "hello of a spare" : "hello";
    if (m.has_probe()) return m.probe().keyframe_follows() ? "probe with" : "probe";
    if (m.has_take_over()) return "take over";
    if (m.has_keyframe()) return "k" + std::to_string(m.keyframe().sequence());
    if (m.has_cloud_chunk()) chunks_ += m.cloud_chunk().data();
    if (m.has_cloud_chunk())
      return "c" + std::to_string(m.cloud_chunk().sequence()) + ":" + std::to_string(m.cloud_chunk().offset() / 1024);
    if (m.has_submap_unavailable()) return "none" + std::to_string(m.submap_unavailable().sequences(0));
    if (m.has_trigger()) return "trigger";
    if (m.has_localize()) return m.localize().stop() ? "where no more" : "where?";
    if (m.has_coverage_request()) return "coverage?";
    if (m.has_pose_update())
      return "u" + std::to_string(m.pose_update().number()) + ":" + std::to_string(m.pose_update().offset()) + "/" +
             std::to_string(m.pose_update().total_poses());
    if (m.has_live()) return "live";
    if (m.has_goodbye()) return m.goodbye().complete() ? "goodbye complete" : "goodbye";
    return m.has_ping() ? "ping" : "pong";
  }

  void hear(const v1::ServerMessage& m) {
    std::string frame;
    ASSERT_TRUE(append_frame(frame, m.SerializeAsString()));
    take(link_->receive(frame, now_));
  }
  void take(const std::vector<UplinkEvent>& events) { events_.insert(events_.end(), events.begin(), events.end()); }
  void welcome(std::uint64_t durable = 0, const std::vector<std::string>& capabilities = {}) {
    v1::ServerMessage m;
    for (const auto& name : capabilities) m.mutable_welcome()->add_capabilities(name);
    m.mutable_welcome()->set_protocol_version(protocol_version);
    m.mutable_welcome()->set_durable_keyframes(durable);
    hear(m);
  }
  void ack(std::uint64_t keyframe) {
    v1::ServerMessage m;
    m.mutable_keyframe_ack()->set_durable_keyframes(keyframe);
    hear(m);
  }
  void ack_cloud(std::uint64_t sequence) {
    v1::ServerMessage m;
    m.mutable_cloud_ack()->add_sequences(sequence);
    hear(m);
  }
  void request(const std::vector<std::uint64_t>& sequences) {
    v1::ServerMessage m;
    for (auto s : sequences) m.mutable_submap_request()->add_sequences(s);
    hear(m);
  }
  const LinkEnded* end() const { return events_.empty() ? nullptr : std::get_if<LinkEnded>(&events_.back()); }

  using Words = std::vector<std::string>;
  UplinkLimits limits_;
  std::size_t chunk_bytes_ = limits::chunk_bytes;
  Table table_;
  UplinkProtocol::Time now_{};
  std::optional<UplinkProtocol> link_;
  std::vector<UplinkEvent> events_;
  std::string chunks_;  // the data of all that were sent
};

}  // namespace headframe
