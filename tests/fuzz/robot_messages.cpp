// Every message that a robot may send, to the server's side of the protocol; with a welcome or before it.
#include <google/protobuf/stubs/logging.h>

#include <algorithm>

#include "server/net/robot_protocol.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/support/next_event.hpp"

namespace headframe::fuzz {
namespace {

constexpr std::uint64_t durable = 3;

Hello hello() { return {{"ant", "s1"}, {"os1", 32, 22, 22, 120}, {{"f", 1}, 3, 2}, CloudPolicy::all, "fuzz", 7}; }

void check(const RobotEvent& event, std::uint64_t& received) {
  if (const auto* keyframe = std::get_if<KeyframeReceived>(&event)) {
    const std::uint64_t sequence = keyframe->keyframe.sequence;
    require(sequence >= 1 && sequence <= received + 1);  // the next one, or a repeat
    received = std::max(received, sequence);
    require(keyframe->keyframe.descriptor.q.size() == 3 && keyframe->keyframe.descriptor.w.size() == 2);
  }
  if (const auto* update = std::get_if<PosesReceived>(&event)) {
    require(update->number >= 1 && !update->poses.empty() && update->poses.back().sequence <= received);
    std::uint64_t last = 0;
    for (const KeyframePose& pose : update->poses) {
      require(pose.sequence > last && pose.T_local_sensor.matrix().allFinite());
      last = pose.sequence;
    }
  }
  if (const auto* cloud = std::get_if<CloudReceived>(&event))
    require(cloud->sequence >= 1 && cloud->sequence <= received);
}

}  // namespace
}  // namespace headframe::fuzz

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  google::protobuf::SetLogHandler(nullptr);  // as the server does
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace headframe;
  RobotProtocol::Time now{};
  RobotProtocol protocol({}, now);
  auto bytes = fuzz::text(data, size);
  std::uint64_t received = fuzz::durable;
  const bool greets = fuzz::take_byte(bytes) % 8 != 0;
  if (greets) {
    v1::RobotMessage message;
    *message.mutable_hello() = to_proto(fuzz::hello());
    std::string frame;
    fuzz::require(append_frame(frame, message.SerializeAsString()).has_value());
    protocol.receive(frame, now);
    fuzz::require(protocol.next().has_value());
    protocol.welcome({fuzz::durable, {1}});
  }
  for (const auto piece : fuzz::pieces(bytes)) {
    std::string frame;
    if (!append_frame(frame, piece)) continue;
    protocol.receive(frame, now += std::chrono::milliseconds(100));
    while (const auto event = next_event(protocol)) {
      if (greets) fuzz::check(*event, received);
      if (const auto* probe = std::get_if<ProbeReceived>(&*event)) protocol.resume(received, !probe->keyframe_follows);
      if (std::holds_alternative<HelloReceived>(*event)) return 0;  // of their own: what follows has other numbers
    }
    if (piece.size() % 16 == 5) protocol.stand_by();
    protocol.tick(now, true);
    protocol.keyframes_durable(received);
    protocol.poses_durable(received);
    (void)protocol.take_output();
  }
  return 0;
}
