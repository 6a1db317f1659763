#pragma once
// A robot's side of the protocol as bytes, for tests of the server.

#include <gtest/gtest.h>

#include "common/cloud/cloud_codec.hpp"
#include "common/wire/convert.hpp"
#include "common/wire/frame_codec.hpp"
#include "common/wire/pose_message.hpp"
#include "tests/support/keyframes.hpp"

namespace headframe {

inline Hello robot_hello(const std::string& robot = "ant") {
  return {{robot, "s1"},
          {"os1-32", 32, 22.5F, 22.5F, 120.0F},
          {{"scan_context", 1}, 3, 2},
          CloudPolicy::on_request,
          "test",
          77};
}

inline std::string frame(const v1::RobotMessage& message) {
  std::string out;
  EXPECT_TRUE(append_frame(out, message.SerializeAsString()));
  return out;
}

inline std::string hello_frame(const Hello& hello = robot_hello()) {
  v1::RobotMessage message;
  *message.mutable_hello() = to_proto(hello);
  return frame(message);
}

inline std::string keyframe_frame(const Keyframe& keyframe) {
  v1::RobotMessage message;
  *message.mutable_keyframe() = to_proto(keyframe).value();
  return frame(message);
}

/// A part of an update.
inline std::string poses_frame(std::uint64_t number, std::size_t total, std::size_t offset,
                               const std::vector<KeyframePose>& poses) {
  v1::RobotMessage message;
  *message.mutable_pose_update() = to_proto(number, total, offset, poses);
  return frame(message);
}

inline std::string probe_frame(bool keyframe_follows) {
  v1::RobotMessage message;
  message.mutable_probe()->set_keyframe_follows(keyframe_follows);
  return frame(message);
}

inline std::string take_over_frame() {
  v1::RobotMessage message;
  (void)message.mutable_take_over();
  return frame(message);
}

inline std::string localize_frame(bool stop) {
  v1::RobotMessage message;
  message.mutable_localize()->set_stop(stop);
  return frame(message);
}

inline std::string chunk_frame(std::uint64_t sequence, std::size_t total, std::size_t offset, const std::string& data) {
  v1::RobotMessage message;
  auto& chunk = *message.mutable_cloud_chunk();
  chunk.set_sequence(sequence);
  chunk.set_total_bytes(static_cast<std::uint32_t>(total));
  chunk.set_offset(static_cast<std::uint32_t>(offset));
  chunk.set_data(data);
  return frame(message);
}

inline std::string goodbye_frame(bool complete) {
  v1::RobotMessage message;
  message.mutable_goodbye()->set_complete(complete);
  return frame(message);
}

/// Some hundred points around the origin, encoded.
inline std::string small_cloud() {
  KeyframeCloud cloud{{Sweep{}}};
  for (int i = 0; i < 400; ++i) cloud.sweeps[0].points.emplace_back(0.05F * i, 3.0F, 0.01F * static_cast<float>(i % 7));
  return encode_cloud(cloud).value();
}

inline std::vector<v1::ServerMessage> messages(const std::string& bytes) {
  std::vector<v1::ServerMessage> all;
  FrameReader reader;
  reader.feed(bytes);
  while (true) {
    const auto payload = reader.next();
    EXPECT_TRUE(payload);
    if (!payload || !*payload) return all;
    EXPECT_TRUE(all.emplace_back().ParseFromString(**payload));
  }
}

}  // namespace headframe
