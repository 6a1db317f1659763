#pragma once
// The server's side of protocol v1 for one connection, without sockets, threads or a clock of its own: bytes and times
// in, events and bytes out.

#include <chrono>
#include <optional>
#include <set>
#include <string_view>

#include "common/wire/frame_codec.hpp"
#include "server/net/cloud_assembler.hpp"
#include "server/net/pose_assembler.hpp"
#include "server/net/robot_events.hpp"
#include "server/net/robot_limits.hpp"
#include "server/net/robot_outbox.hpp"

namespace headframe {

/// Not thread safe. Whatever a peer sends, the worst that happens is a typed error and the end of this connection.
class RobotProtocol {
 public:
  using Time = std::chrono::steady_clock::time_point;

  RobotProtocol(const RobotLimits& limits, Time now) : limits_(limits), born_(now), now_(now), heard_(now) {}

  void receive(std::string_view bytes, Time now);

  /// The next event; nullopt: more bytes are needed, the hello waits for its answer, or the connection has ended. Bytes
  /// that were received and not asked for yet stay where they are.
  std::optional<RobotEvent> next();

  /// Deadlines and pings. reading: false while the caller leaves the robot's bytes in the socket, so that its silence
  /// is not held against it.
  void tick(Time now, bool reading);

  /// Answers HelloReceived.
  void welcome(const Durable& durable);
  /// Answers ProbeReceived: keyframes go on from here. acknowledge: at once, not only when the next one is durable.
  void resume(std::uint64_t durable_keyframes, bool acknowledge);

  /// Answers CloudArrived: whether it decodes, which takes too long for a thread that serves all. What comes of it.
  RobotEvent checked(CloudArrived cloud, const Result<void>& decodes);
  static Result<void> check(const CloudArrived& cloud);

  /// Another connection carries the session: chunks of clouds and updates of poses are passed over here, for they come
  /// anew there.
  void stand_by();

  /// Ends the connection with a typed error.
  void fail(v1::ErrorKind kind, const std::string& message, bool permanent);

  void keyframes_durable(std::uint64_t sequence);
  void poses_durable(std::uint64_t update) { outbox_.acknowledge_poses(update); }
  void cloud_durable(std::uint64_t sequence) { outbox_.acknowledge_cloud(sequence); }
  /// The robot drops this cloud; the connection goes on.
  void refuse_cloud(std::uint64_t sequence, const std::string& reason) { outbox_.refuse_cloud(sequence, reason); }
  void request_submap(const std::vector<std::uint64_t>& sequences) { outbox_.request_submap(sequences); }
  void update_transform(std::shared_ptr<const TransformPages> pages) { outbox_.update_transform(std::move(pages)); }

  /// A serialised ServerMessage.
  void tell_localization(std::shared_ptr<const std::string> payload) { outbox_.localization(std::move(payload)); }

  /// The same; it goes when nothing else waits, and takes the place of one of its kind that waits.
  void tell_surroundings(SurroundingsKind kind, std::shared_ptr<const std::string> payload) {
    outbox_.surroundings(kind, std::move(payload));
  }

  void tell_policy(LinkPolicy policy) { outbox_.policy(std::move(policy)); }

  std::string take_output() { return outbox_.take(); }

  /// Nothing more is read: close once the output is written.
  bool ended() const { return state_ == State::ended; }
  bool welcomed() const { return state_ == State::welcomed; }
  /// Why it ended, for the log.
  const std::string& reason() const { return reason_; }

 private:
  static constexpr double most_live_at_once = 10;  // what a link holds back comes in one go
  enum class State { hello_awaited, answer_awaited, welcomed, ended };

  std::optional<RobotEvent> handle(const v1::RobotMessage& message);
  std::optional<RobotEvent> on_hello(const v1::Hello& message);
  std::optional<RobotEvent> on_keyframe(const v1::Keyframe& message, std::uint64_t backlog);
  std::optional<RobotEvent> on_live(const v1::LiveState& message, std::uint64_t backlog);
  std::optional<RobotEvent> on_poses(const v1::PoseUpdate& message);
  std::optional<RobotEvent> on_chunk(const v1::CloudChunk& message);
  std::optional<RobotEvent> on_unavailable(const v1::SubmapUnavailable& message);
  std::optional<RobotEvent> refused(std::uint64_t sequence, const std::string& reason);
  std::nullopt_t out_of_order(const std::string& message);
  std::nullopt_t bad_message(const std::string& message);

  RobotLimits limits_;
  State state_ = State::hello_awaited;
  Time born_, now_, heard_;  // heard_: when the last whole message came
  bool asked_ = false;       // a ping since then
  std::uint64_t pings_ = 0;
  FrameReader frames_;
  CloudAssembler clouds_;
  PoseAssembler poses_;
  std::set<std::uint64_t> skipped_;  // clouds that were refused half-way: the rest of them is not looked at
  RobotOutbox outbox_;
  FamilySpec family_;
  bool spare_ = false;
  std::uint64_t received_ = 0, durable_ = 0;  // keyframes
  bool complete_ = false;
  double live_left_ = most_live_at_once;  // states that may come now: one more each second
  Time live_counted_{};
  std::string reason_;
};

}  // namespace headframe
