#include "server/net/robot_protocol.hpp"

#include <algorithm>

#include "common/cloud/cloud_codec.hpp"

namespace headframe {
namespace {

constexpr std::size_t most_skipped = 1024;
constexpr std::size_t trigger_reason_bytes = 256;  // for the log

double seconds(RobotProtocol::Time from, RobotProtocol::Time to) {
  return std::chrono::duration<double>(to - from).count();
}

SurroundingsAsked asked(SurroundingsKind kind, const v1::SurroundingsRequest& message) {
  return {kind, !message.stop(), {message.epoch(), message.version()}};
}

/// Whether there may be such a map is said by whoever makes it.
MapAsked asked(const v1::MapRequest& message) {
  MapAsked out{message.id(), {}, message.resolution_m(), {message.epoch(), message.version()}};
  if (message.has_sphere()) {
    const v1::Sphere& s = message.sphere();
    out.region = SphereRegion{{s.x(), s.y(), s.z()}, s.radius_m()};
  } else if (message.has_box()) {
    const v1::Box& b = message.box();
    out.region = BoxRegion{{b.low_x(), b.low_y(), b.low_z()}, {b.high_x(), b.high_y(), b.high_z()}};
  }
  return out;
}

std::string tenths(double s) {
  std::string text = std::to_string(s);
  return text.substr(0, text.find('.') + 2);
}

}  // namespace

void RobotProtocol::receive(std::string_view bytes, Time now) {
  now_ = now;
  if (!ended()) frames_.feed(bytes);
}

std::optional<RobotEvent> RobotProtocol::next() {
  while (state_ == State::hello_awaited || state_ == State::welcomed) {
    const auto payload = frames_.next();
    if (!payload) {
      fail(v1::ERROR_KIND_FRAME_TOO_LARGE, payload.error().message, true);
      break;
    }
    if (!*payload) break;
    heard_ = now_;
    asked_ = false;
    v1::RobotMessage message;
    if (!message.ParseFromString(**payload)) return bad_message("a frame is no RobotMessage of protocol v1");
    if (auto event = handle(message)) return event;
  }
  return std::nullopt;
}

std::optional<RobotEvent> RobotProtocol::handle(const v1::RobotMessage& message) {
  using Body = v1::RobotMessage;
  if (message.body_case() == Body::kHello) return on_hello(message.hello());
  if (state_ != State::welcomed)
    return out_of_order("the first message must be a hello, nothing else before its welcome");
  switch (message.body_case()) {
    case Body::kKeyframe: return on_keyframe(message.keyframe(), message.backlog());
    case Body::kPoseUpdate: return on_poses(message.pose_update());
    case Body::kCloudChunk: return on_chunk(message.cloud_chunk());
    case Body::kSubmapUnavailable: return on_unavailable(message.submap_unavailable());
    case Body::kTrigger: return TriggerRequested{message.trigger().reason().substr(0, trigger_reason_bytes)};
    case Body::kLocalize: return WhereAsked{!message.localize().stop()};
    case Body::kTrajectoriesRequest: return asked(SurroundingsKind::trajectories, message.trajectories_request());
    case Body::kCoverageRequest: return asked(SurroundingsKind::coverage, message.coverage_request());
    case Body::kMapRequest: return asked(message.map_request());
    case Body::kMapNext: return MapNextAsked{message.map_next().id(), message.map_next().offset()};
    case Body::kLive: return on_live(message.live(), message.backlog());
    case Body::kGoodbye: complete_ = message.goodbye().complete(); return GoodbyeReceived{complete_};
    case Body::kPing: outbox_.pong(message.ping().nonce()); return std::nullopt;
    case Body::kPong: return std::nullopt;
    case Body::kProbe: return ProbeReceived{message.probe().keyframe_follows()};
    case Body::kTakeOver: spare_ = false; return TakenOver{};
    default: return bad_message("a message without a body that protocol v1 knows");
  }
}

std::optional<RobotEvent> RobotProtocol::on_hello(const v1::Hello& message) {
  if (state_ != State::hello_awaited) return out_of_order("a second hello on one connection");
  if (message.protocol_version() != protocol_version) {
    fail(v1::ERROR_KIND_PROTOCOL_VERSION,
         "robot speaks protocol " + std::to_string(message.protocol_version()) + ", this server " +
             std::to_string(protocol_version) + ": update the older of the two",
         true);
    return std::nullopt;
  }
  auto hello = from_proto(message);
  if (!hello) return bad_message("hello: " + hello.error().message);
  family_ = hello->family;
  spare_ = hello->spare;
  state_ = State::answer_awaited;
  return HelloReceived{std::move(*hello)};
}

void RobotProtocol::welcome(const Durable& durable) {
  if (state_ != State::answer_awaited) return;
  state_ = State::welcomed;
  received_ = durable_ = durable.keyframes;
  outbox_.welcome(durable, limits_.spares);
}

/// Other connections of the session may have brought more than this one.
void RobotProtocol::resume(std::uint64_t durable_keyframes, bool acknowledge) {
  received_ = durable_ = durable_keyframes;
  if (acknowledge) outbox_.acknowledge_keyframes(durable_);
}

void RobotProtocol::stand_by() {
  spare_ = true;
  clouds_ = {};
  poses_ = {};
  skipped_.clear();
}

std::optional<RobotEvent> RobotProtocol::on_keyframe(const v1::Keyframe& message, std::uint64_t backlog) {
  auto keyframe = from_proto(message);
  const std::string name = "keyframe " + std::to_string(message.sequence()) + ": ";
  if (!keyframe) return bad_message(name + keyframe.error().message);
  if (auto fits = complete(*keyframe, family_); !fits) return bad_message(name + fits.error().message);
  if (keyframe->sequence <= received_) return KeyframeReceived{std::move(*keyframe), backlog};  // the store compares
  if (complete_) return out_of_order(name + "the robot said goodbye to a complete session before");
  if (keyframe->sequence != received_ + 1)
    return out_of_order(name + "a hole in the sequence, " + std::to_string(received_ + 1) + " comes next");
  received_ = keyframe->sequence;
  return KeyframeReceived{std::move(*keyframe), backlog};
}

/// Keyframes come first: of one that was not received nothing is taken.
std::optional<RobotEvent> RobotProtocol::on_poses(const v1::PoseUpdate& message) {
  const std::string name = "update " + std::to_string(message.number()) + " of poses: ";
  auto part = from_proto(message);
  if (!part) return bad_message(name + part.error().message);
  if (spare_) return std::nullopt;
  if (const std::uint64_t last = part->poses.back().sequence; last > received_)
    return out_of_order(name + "of keyframe " + std::to_string(last) + ", which was not received");
  auto whole = poses_.add(std::move(*part));
  if (!whole) return bad_message(name + whole.error().message);
  if (!*whole) return std::nullopt;
  return PosesReceived{message.number(), received_, std::move(**whole)};
}

/// A spare's is passed over, and so is what comes more often than each second.
std::optional<RobotEvent> RobotProtocol::on_live(const v1::LiveState& message, std::uint64_t backlog) {
  auto state = from_proto(message);
  if (!state) return bad_message("live state: " + state.error().message);
  live_left_ = std::min(most_live_at_once, live_left_ + seconds(live_counted_, now_));
  live_counted_ = now_;
  if (spare_ || live_left_ < 1) return std::nullopt;
  live_left_ -= 1;
  return LiveReceived{std::move(*state), backlog};
}

std::optional<RobotEvent> RobotProtocol::on_chunk(const v1::CloudChunk& message) {
  if (spare_) return std::nullopt;
  if (message.sequence() == 0 || message.sequence() > received_)
    return out_of_order("cloud of keyframe " + std::to_string(message.sequence()) + ", which was not received");
  const bool is_last = message.offset() + std::uint64_t{message.data().size()} >= message.total_bytes();
  if (message.offset() > 0 && skipped_.contains(message.sequence())) {
    if (is_last) skipped_.erase(message.sequence());
    return std::nullopt;
  }
  skipped_.erase(message.sequence());
  auto whole = clouds_.add(message.sequence(), message.total_bytes(), message.offset(), message.data());
  if (!whole) {
    clouds_.forget(message.sequence());
    if (skipped_.size() == most_skipped) skipped_.clear();  // at worst a refusal is said twice
    if (!is_last) skipped_.insert(message.sequence());
    return refused(message.sequence(), whole.error().message);
  }
  if (!*whole) return std::nullopt;
  return CloudArrived{message.sequence(), std::move(**whole)};
}

Result<void> RobotProtocol::check(const CloudArrived& cloud) {
  return decode_cloud(cloud.encoded).map([](const KeyframeCloud&) {});
}

RobotEvent RobotProtocol::checked(CloudArrived cloud, const Result<void>& decodes) {
  if (!decodes) return *refused(cloud.sequence, decodes.error().message);
  return CloudReceived{cloud.sequence, std::move(cloud.encoded)};
}

std::optional<RobotEvent> RobotProtocol::refused(std::uint64_t sequence, const std::string& reason) {
  refuse_cloud(sequence, reason);
  return CloudRefused{sequence, reason};
}

std::optional<RobotEvent> RobotProtocol::on_unavailable(const v1::SubmapUnavailable& message) {
  CloudsUnavailable event{{message.sequences().begin(), message.sequences().end()}};
  std::erase_if(event.sequences, [&](std::uint64_t s) { return s == 0 || s > received_; });
  return event;
}

void RobotProtocol::keyframes_durable(std::uint64_t sequence) {
  durable_ = std::max(durable_, sequence);
  outbox_.acknowledge_keyframes(durable_);
}

void RobotProtocol::tick(Time now, bool reading) {
  now_ = now;
  if (ended()) return;
  if (!welcomed()) {
    if (seconds(born_, now) >= limits_.hello_s)
      fail(v1::ERROR_KIND_BAD_MESSAGE, "no hello within " + tenths(limits_.hello_s) + " s", false);
    return;
  }
  if (!reading) heard_ = now;
  const double silent_s = seconds(heard_, now);
  if (silent_s >= limits_.silence_s) {
    fail(v1::ERROR_KIND_UNSPECIFIED, "no message within " + tenths(limits_.silence_s) + " s, not even a pong", false);
  } else if (silent_s >= limits_.ping_s && !asked_ && !spare_) {
    asked_ = true;
    outbox_.ping(++pings_);
  }
}

void RobotProtocol::fail(v1::ErrorKind kind, const std::string& message, bool permanent) {
  if (ended()) return;
  state_ = State::ended;
  reason_ = message;
  outbox_.error(kind, message, permanent);
}

std::nullopt_t RobotProtocol::out_of_order(const std::string& message) {
  fail(v1::ERROR_KIND_OUT_OF_ORDER, message, false);
  return std::nullopt;
}

std::nullopt_t RobotProtocol::bad_message(const std::string& message) {
  fail(v1::ERROR_KIND_BAD_MESSAGE, message, true);
  return std::nullopt;
}

}  // namespace headframe
