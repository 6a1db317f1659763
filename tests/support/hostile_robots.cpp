// Robots that were let in and mean harm.

#include <array>
#include <memory>

#include "tests/support/tls_peer.hpp"

namespace headframe::test {
namespace {

/// Small clouds that decode to millions of points, one after the other.
void decoding(const HostileTarget& target) {
  static const std::string cloud =
      encode_cloud({{{Eigen::Vector3f::Zero(), Points(3'900'000, Eigen::Vector3f(2, 2, 0))}}}).value();
  Accomplice robot(target);
  for (std::uint64_t i = 1; i <= 20; ++i) robot.send(keyframe_frame(line_keyframe(i)) + cloud_frames(i, cloud));
  robot.settle();
}

void damaged_clouds(const HostileTarget& target) {
  Accomplice robot(target);
  for (std::uint64_t i = 1; i <= 500; ++i)
    robot.send(keyframe_frame(line_keyframe(i, 0.01)) + cloud_frames(i, "no cloud at all"));
  robot.settle();
}

void clouds_in_pieces(const HostileTarget& target) {
  Accomplice robot(target);
  robot.send(keyframe_frame(line_keyframe(1)));
  for (int i = 0; i < 2000; ++i) robot.send(chunk_frame(1, 16U << 20, static_cast<std::size_t>(i % 7), "x"));
  robot.settle();
}

void keyframe_flood(const HostileTarget& target) {
  Accomplice robot(target);
  std::string all;
  for (std::uint64_t i = 1; i <= 3000; ++i) all += keyframe_frame(line_keyframe(i, 0.001));
  robot.send(all);
  robot.settle();
}

void other_content(const HostileTarget& target) {
  Accomplice robot(target);
  std::string all;
  for (std::uint64_t i = 1; i <= 500; ++i) all += keyframe_frame(line_keyframe(i, 0.01));
  for (std::uint64_t i = 1; i <= 500; ++i) all += keyframe_frame(line_keyframe(i, 0.02));
  robot.send(all);
  robot.settle();
}

void repeats(const HostileTarget& target) {
  static const std::string all = [] {
    std::string frames;
    for (int i = 0; i < 2000; ++i) frames += keyframe_frame(line_keyframe(1));
    return frames;
  }();
  Accomplice robot(target);
  robot.send(all);
  robot.settle();
}

void asks_on_and_on(const HostileTarget& target) {
  v1::RobotMessage message;
  message.mutable_trigger()->set_reason(std::string(200, '!'));
  std::string all;
  for (int i = 0; i < 3000; ++i) all += frame(message);
  Accomplice robot(target);
  robot.send(keyframe_frame(line_keyframe(1)) + all);
  robot.settle();
}

void pings(const HostileTarget& target) {
  std::string all;
  for (std::uint64_t i = 1; i <= 5000; ++i) all += frame(pinged(i + 10));
  Accomplice robot(target);
  robot.send(all);
  robot.settle();
}

void has_no_clouds(const HostileTarget& target) {
  v1::RobotMessage message;
  for (std::uint64_t i = 1; i <= 20000; ++i) message.mutable_submap_unavailable()->add_sequences(i);
  Accomplice robot(target);
  robot.send(keyframe_frame(line_keyframe(1)));
  for (int i = 0; i < 50; ++i) robot.send(frame(message));
  robot.settle();
}

void numbers_that_are_none(const HostileTarget& target) {
  v1::RobotMessage message;
  *message.mutable_keyframe() = to_proto(line_keyframe(1)).value();
  message.mutable_keyframe()->set_q("\xff\x7f\xff\x7f\x01\x00");  // NaN in binary16
  Accomplice robot(target);
  robot.send(frame(message));
  robot.settle();
}

void many_sessions(const HostileTarget& target) {
  for (int i = 0; i < 40; ++i) (void)Accomplice(target);
}

void many_connections(const HostileTarget& target) {
  std::array<std::unique_ptr<Accomplice>, 64> all;
  for (auto& one : all) one = std::make_unique<Accomplice>(target);
}

/// Connects to one session over and over: each time counts as a reason to try it.
void comes_and_goes(const HostileTarget& target) {
  for (int i = 0; i < 50; ++i)
    Accomplice(target, robot_hello().family, "revolving").send(keyframe_frame(line_keyframe(1)));
}

void takes_no_bytes(const HostileTarget& target) {
  Accomplice robot(target);
  std::string all;
  for (std::uint64_t i = 1; i <= 5000; ++i) all += frame(pinged(i + 10));
  for (int i = 0; i < 10; ++i) robot.send(all);
}

void control_characters(const HostileTarget& target) {
  Hello hello = accomplice_hello(target, new_name());
  hello.software = "1.0\n[error] robot admin has enrolled\x1b[2J\xe2\x80\xae";
  TlsPeer peer(target);
  peer.greet(hello);
}

}  // namespace

const std::vector<HostileAct>& hostile_robots() {
  static const std::vector<HostileAct> acts{
      {"clouds of millions of points", decoding}, {"damaged clouds", damaged_clouds},
      {"clouds in pieces", clouds_in_pieces},     {"keyframe flood", keyframe_flood},
      {"other content", other_content},           {"repeats", repeats},
      {"asks on and on", asks_on_and_on},         {"pings", pings},
      {"has no clouds", has_no_clouds},           {"numbers that are none", numbers_that_are_none},
      {"many sessions", many_sessions},           {"many connections", many_connections},
      {"comes and goes", comes_and_goes},         {"takes no bytes", takes_no_bytes},
      {"control characters", control_characters},
  };
  return acts;
}

}  // namespace headframe::test
