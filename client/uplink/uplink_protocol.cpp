#include "client/uplink/uplink_protocol.hpp"

#include <algorithm>
#include <iterator>

#include "client/uplink/transform_update.hpp"
#include "common/printable.hpp"
#include "common/wire/capabilities.hpp"
#include "common/wire/limits.hpp"

namespace headframe {
namespace {

constexpr std::size_t most_control_frames = 64;
constexpr std::size_t reason_bytes = 256;

double seconds(UplinkProtocol::Time from, UplinkProtocol::Time to) {
  return std::chrono::duration<double>(to - from).count();
}

ErrorCode code_of(v1::ErrorKind kind) {
  switch (kind) {
    case v1::ERROR_KIND_PROTOCOL_VERSION: return ErrorCode::incompatible;
    case v1::ERROR_KIND_REFUSED: return ErrorCode::refused;
    case v1::ERROR_KIND_BAD_MESSAGE:
    case v1::ERROR_KIND_FRAME_TOO_LARGE:
    case v1::ERROR_KIND_OUT_OF_ORDER: return ErrorCode::bad_input;
    default: return ErrorCode::unavailable;
  }
}

}  // namespace

std::string printable_text(const std::string& peer_text) {
  return printable(std::string_view(peer_text).substr(0, 1024));
}

UplinkProtocol::UplinkProtocol(const UplinkLimits& limits, const Hello& hello, const UplinkSource& source, Time now)
    : limits_(limits), hello_(hello), source_(source), born_(now), heard_(now) {}

std::string UplinkProtocol::hello_frame() const {
  v1::RobotMessage message;
  *message.mutable_hello() = to_proto(hello_);
  message.mutable_hello()->set_spare(!carries_);
  std::string frame;
  (void)append_frame(frame, message.SerializeAsString());  // names are short: it fits
  return frame;
}

// A full queue drops the newest: only pongs to a server that pings without reading can fill it.
void UplinkProtocol::queue(const v1::RobotMessage& message) {
  std::string frame;
  if (append_frame(frame, message.SerializeAsString())) (void)queue_frames(std::move(frame));
}

bool UplinkProtocol::queue_frames(std::string frames) {
  if (control_.size() >= most_control_frames) return false;
  control_.push_back(std::move(frames));
  return true;
}

std::vector<UplinkEvent> UplinkProtocol::receive(std::string_view bytes, Time now) {
  Events events;
  if (ended()) return events;
  frames_.feed(bytes);
  bool heard = false;
  while (!ended()) {
    const auto payload = frames_.next();
    if (!payload) {
      end(events, ErrorCode::bad_input, "from the server: " + payload.error().message, false);
      break;
    }
    if (!*payload) break;
    heard_ = now;
    heard = true;
    asked_ = false;
    v1::ServerMessage message;
    if (message.ParseFromString(**payload))
      handle(message, events);
    else
      end(events, ErrorCode::bad_input, "from the server: a frame is no ServerMessage of protocol v1", false);
  }
  if (heard) {
    answer_since_.reset();
    expect_answer(now);
  }
  return events;
}

std::vector<UplinkEvent> UplinkProtocol::tick(Time now) {
  Events events;
  if (ended()) return events;
  const double silent_s = seconds(heard_, now);
  if (!welcomed() && seconds(born_, now) >= limits_.welcome_s) {
    end(events, ErrorCode::unavailable, "the server did not answer the hello: is it a headframe server?", false);
  } else if (silent_s >= limits_.silence_s) {
    end(events, ErrorCode::unavailable, "the server fell silent", false);
  } else if (welcomed() && !asked_ &&
             (silent_s >= (carries_ ? limits_.ping_s : limits_.spare_ping_s) ||
              (answer_since_ && seconds(*answer_since_, now) >= limits_.doubt_s / 2))) {
    ping();
  }
  return events;
}

void UplinkProtocol::ping() {
  asked_ = true;
  v1::RobotMessage message;
  message.mutable_ping()->set_nonce(++pings_);
  queue(message);
}

bool UplinkProtocol::doubtful(Time now) const {
  return !ended() && answer_since_ && seconds(*answer_since_, now) >= limits_.doubt_s;
}

void UplinkProtocol::expect_answer(Time now) {
  const bool due = asked_ || !welcomed() || sent_keyframes_ > durable_keyframes_ || sent_update_ > durable_update_ ||
                   !clouds_in_flight_.empty();
  if (due && !answer_since_) answer_since_ = now;
}

void UplinkProtocol::handle(const v1::ServerMessage& message, Events& events) {
  using Body = v1::ServerMessage;
  if (message.body_case() == Body::kError) return on_error(message.error(), events);
  if (message.body_case() == Body::kWelcome) return on_welcome(message.welcome(), events);
  if (!welcomed()) return end(events, ErrorCode::bad_input, "from the server: a message before its welcome", false);
  switch (message.body_case()) {
    case Body::kKeyframeAck: return on_keyframe_ack(message.keyframe_ack().durable_keyframes(), events);
    case Body::kPoseUpdateAck: return on_poses_ack(message.pose_update_ack().durable_pose_update(), events);
    case Body::kCloudAck:
      for (const auto sequence : message.cloud_ack().sequences()) on_cloud_ack(sequence, events);
      return;
    case Body::kCloudRefusal: return on_cloud_refusal(message.cloud_refusal(), events);
    // The server sends these on a spare only if they were already on their way, and sends them again after a takeover.
    case Body::kSubmapRequest: return carries_ ? on_submap_request(message.submap_request()) : void();
    case Body::kTransformUpdate: return carries_ ? on_transforms(message.transform_update(), events) : void();
    case Body::kLocalization: return carries_ ? on_localization(message.localization(), events) : void();
    case Body::kTrajectories:
    case Body::kCoverage:
    case Body::kMapPart:
      if (carries_) events.emplace_back(SurroundingsMessage{std::make_shared<const v1::ServerMessage>(message)});
      return;
    case Body::kLinkPolicy:
      policy_ = {static_cast<double>(message.link_policy().bytes_per_s()), printable_text(message.link_policy().hold()),
                 printable_text(message.link_policy().cut())};
      if (carries_) events.emplace_back(policy_);
      return;
    case Body::kPing: {
      v1::RobotMessage pong;
      pong.mutable_pong()->set_nonce(message.ping().nonce());
      return queue(pong);
    }
    default: return;  // a pong, or a body that a later minor version adds
  }
}

void UplinkProtocol::on_welcome(const v1::Welcome& message, Events& events) {
  if (welcomed()) return end(events, ErrorCode::bad_input, "from the server: a second welcome", false);
  if (message.protocol_version() != protocol_version)
    return end(events, ErrorCode::incompatible,
               "the server speaks protocol " + std::to_string(message.protocol_version()) + ", this robot " +
                   std::to_string(protocol_version) + ": update the older of the two",
               true);
  const auto is_old_copy = [&](const std::string& held, std::uint64_t in_spool) {
    end(events, ErrorCode::refused,
        "the server holds " + held + ", the spool only " + std::to_string(in_spool) +
            ": it is an old copy; begin a new session",
        true);
  };
  if (message.durable_keyframes() > source_.last_sequence())
    return is_old_copy(std::to_string(message.durable_keyframes()) + " keyframes of this session",
                       source_.last_sequence());
  if (message.durable_pose_update() > source_.last_pose_update())
    return is_old_copy("update " + std::to_string(message.durable_pose_update()) + " of this session's poses",
                       source_.last_pose_update());
  state_ = State::welcomed;
  sent_keyframes_ = durable_keyframes_ = message.durable_keyframes();
  auto capabilities = usable_capabilities({message.capabilities().begin(), message.capabilities().end()});
  const auto knows = [&](std::string_view name) {
    return std::find(capabilities.begin(), capabilities.end(), name) != capabilities.end();
  };
  localizes_ = knows(localize_capability);
  knows_around_ = knows(surroundings_capability);
  takes_live_ = knows(live_capability);
  takes_poses_ = knows(poses_capability);
  sent_update_ = durable_update_ = message.durable_pose_update();
  takes_intensity_ = knows(cloud_intensity_capability);
  events.emplace_back(Welcomed{message.spares(), std::move(capabilities)});
  events.emplace_back(KeyframesDurable{durable_keyframes_});
  events.emplace_back(PosesDurable{durable_update_});
  for (const auto& range : message.durable_clouds())
    if (range.first() <= range.last()) events.emplace_back(CloudsDurable{range.first(), range.last()});
}

void UplinkProtocol::on_keyframe_ack(std::uint64_t up_to, Events& events) {
  if (up_to > (carried_alone_ ? sent_keyframes_ : source_.last_sequence()))
    return end(events, ErrorCode::bad_input, "from the server: an ack of a keyframe that was not sent", false);
  durable_keyframes_ = std::max(durable_keyframes_, up_to);
  sent_keyframes_ = std::max(sent_keyframes_, durable_keyframes_);
  if (probed_ == Probed::asked) probed_ = Probed::answered;
  events.emplace_back(KeyframesDurable{durable_keyframes_});
}

void UplinkProtocol::on_transforms(const v1::TransformUpdate& message, Events& events) {
  auto transforms = transforms_from(message);
  if (!transforms) return end(events, ErrorCode::bad_input, "transform update: " + transforms.error().message, false);
  if (joins_pages(message, *transforms)) events.emplace_back(std::move(*transforms));
}

/// Returns true when the update is complete with all its pages. A page that does not follow the one before is dropped,
/// and so is everything until the next update begins; the server then sends another one.
bool UplinkProtocol::joins_pages(const v1::TransformUpdate& message, Transforms& transforms) {
  constexpr std::size_t most_sessions = 200000;
  if (message.page() == 0) {
    pages_ = std::move(transforms);
    next_page_ = 1;
  } else {
    const bool follows = pages_ && pages_->revision == transforms.revision &&
                         pages_->component == transforms.component && message.page() == next_page_ &&
                         pages_->sessions.size() + transforms.sessions.size() <= most_sessions;
    if (!follows) {
      pages_.reset();
      return false;
    }
    ++next_page_;
    std::move(transforms.sessions.begin(), transforms.sessions.end(), std::back_inserter(pages_->sessions));
    pages_->provisional = std::move(transforms.provisional);
    pages_->withdrawn = std::move(transforms.withdrawn);
  }
  if (next_page_ < message.pages()) return false;
  transforms = std::move(*pages_);
  pages_.reset();
  return true;
}

void UplinkProtocol::on_error(const v1::ErrorReport& message, Events& events) {
  end(events, code_of(message.kind()), "the server says: " + printable_text(message.message()), message.permanent());
}

void UplinkProtocol::end(Events& events, ErrorCode code, const std::string& message, bool permanent) {
  state_ = State::ended;
  events.emplace_back(LinkEnded{{code, message}, permanent});
}

void UplinkProtocol::trigger(const std::string& reason) {
  v1::RobotMessage message;
  message.mutable_trigger()->set_reason(reason.substr(0, reason_bytes));
  queue(message);
}

void UplinkProtocol::goodbye(bool complete) {
  if (said_goodbye_) return;
  v1::RobotMessage message;
  message.mutable_goodbye()->set_complete(complete);
  queue(message);
  said_goodbye_ = true;
}

std::optional<std::string> UplinkProtocol::next_frame(Time now, std::size_t chunk_bytes, Events& events) {
  if (ended()) return std::nullopt;
  if (!said_hello_) {
    said_hello_ = true;
    expect_answer(now);
    return hello_frame();
  }
  if (!welcomed()) return std::nullopt;  // only the hello may go earlier; triggers wait in the queue behind it
  if (control_.empty() && carries_ && !said_goodbye_ && chunk_bytes > 0) queue_live(now);
  if (control_.empty() && carries_ && !said_goodbye_ && policy_.hold.empty())
    if (!queue_poses(chunk_bytes, events) && !queue_next_keyframe(events) && chunk_bytes > 0)
      queue_next_chunk(chunk_bytes, events);
  if (control_.empty()) return std::nullopt;
  expect_answer(now);
  std::string frame = std::move(control_.front());
  control_.pop_front();
  return frame;
}

Result<v1::RobotMessage> UplinkProtocol::next_keyframe() const {
  const auto keyframe = source_.keyframe(sent_keyframes_ + 1);
  auto message = keyframe ? to_proto(*keyframe) : tl::unexpected(keyframe.error());
  if (!message) return tl::unexpected(message.error());
  v1::RobotMessage body;
  *body.mutable_keyframe() = std::move(*message);
  body.set_backlog(source_.last_sequence() - sent_keyframes_ - 1);
  return body;
}

bool UplinkProtocol::queue_next_keyframe(Events& events) {
  if (sent_keyframes_ >= source_.last_sequence() || sent_keyframes_ - durable_keyframes_ >= limits_.keyframes_in_flight)
    return false;
  const auto body = next_keyframe();
  if (!body) {
    end(events, body.error().code, body.error().message, true);  // because no keyframe may be skipped
    return false;
  }
  ++sent_keyframes_;
  queue(*body);
  return true;
}

}  // namespace headframe
