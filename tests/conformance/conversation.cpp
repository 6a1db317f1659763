#include "tests/conformance/conversation.hpp"

#include <algorithm>

#include "common/wire/limits.hpp"

namespace headframe::conformance {
namespace {

constexpr std::uint64_t keyframes_on_their_way = 64;
constexpr std::size_t clouds_on_their_way = 16;

std::string keyframe_name(std::uint64_t sequence) { return "keyframe " + std::to_string(sequence); }
std::string cloud_name(std::uint64_t sequence) { return "cloud of keyframe " + std::to_string(sequence); }

}  // namespace

bool Conversation::greet() {
  if (!peer_.handshake(Clock::now() + patience_)) {
    findings_.wrong("tls", "no TLS 1.3 handshake: " + peer_.words());
    return false;
  }
  const auto message = peer_.read(Clock::now() + patience_);
  if (!message) {
    const bool frame = peer_.trouble() == Peer::Trouble::bad_frame || peer_.trouble() == Peer::Trouble::no_message;
    findings_.wrong(frame ? "frame" : "hello", frame
                                                   ? "what came first is no frame with a RobotMessage: " + peer_.words()
                                                   : std::string("no hello came"));
    return false;
  }
  findings_.check(message->has_hello(), "before-welcome", "the first message is no hello");
  if (!message->has_hello()) return false;
  session_ = message->hello().session().session();
  judge_.hello(message->hello());
  return true;
}

void Conversation::welcome(std::uint64_t durable, const std::vector<std::uint64_t>& clouds, bool in_pieces) {
  v1::ServerMessage message;
  auto& welcome = *message.mutable_welcome();
  welcome.set_protocol_version(protocol_version);
  welcome.set_durable_keyframes(durable);
  for (const auto sequence : clouds) {
    auto& range = *welcome.add_durable_clouds();
    range.set_first(sequence);
    range.set_last(sequence);
  }
  welcome.add_capabilities("cloud_form_1");
  welcome.add_capabilities("a_capability_of_a_later_server");
  durable_ = last_ = durable;
  welcomed_ = true;
  judge_.welcomed();
  (void)peer_.send(message, in_pieces);
}

void Conversation::acknowledge(std::uint64_t keyframe) {
  durable_ = std::max(durable_, keyframe);
  v1::ServerMessage message;
  message.mutable_keyframe_ack()->set_durable_keyframes(durable_);
  say(message);
}

void Conversation::acknowledge_cloud(std::uint64_t sequence) {
  if (std::erase(unacknowledged_, sequence) == 0) return;
  station_.acknowledged.insert(sequence);
  v1::ServerMessage message;
  message.mutable_cloud_ack()->add_sequences(sequence);
  say(message);
}

void Conversation::refuse_cloud(std::uint64_t sequence) {
  std::erase(unacknowledged_, sequence);
  station_.refused.insert(sequence);
  v1::ServerMessage message;
  message.mutable_cloud_refusal()->set_sequence(sequence);
  message.mutable_cloud_refusal()->set_reason("conformance: one cloud is refused, the link goes on");
  say(message);
}

void Conversation::request(const std::vector<std::uint64_t>& sequences) {
  v1::ServerMessage message;
  for (const auto sequence : sequences) {
    message.mutable_submap_request()->add_sequences(sequence);
    if (!open_.contains(sequence)) requested_.push_back(sequence);
    asked_.insert(sequence);
    answered_.erase(sequence);
  }
  say(message);
}

void Conversation::hold(const std::string& why) {
  v1::ServerMessage message;
  message.mutable_link_policy()->set_hold(why);
  if (why.empty()) held_ = false;
  say(message);
  if (!why.empty()) held_ = settle();
}

void Conversation::pace(std::uint64_t bytes_per_s) {
  v1::ServerMessage message;
  message.mutable_link_policy()->set_bytes_per_s(bytes_per_s);
  say(message);
  (void)settle();
}

void Conversation::tell_transforms(const std::string& robot, const std::string& session) {
  v1::ServerMessage message;
  auto& update = *message.mutable_transform_update();
  update.set_revision(7);
  update.set_component(1);
  update.mutable_anchor()->set_robot("another");
  update.mutable_anchor()->set_session("earlier");
  for (const auto& [name, of] : {std::pair{std::string("another"), std::string("earlier")}, {robot, session}}) {
    auto& placed = *update.add_sessions();
    placed.mutable_session()->set_robot(name);
    placed.mutable_session()->set_session(of);
    *placed.mutable_t_component_session() = to_proto(pose_from_yaw(0.3, {1, 2, 3}));
  }
  say(message);
}

void Conversation::error(v1::ErrorKind kind, bool permanent) {
  v1::ServerMessage message;
  message.mutable_error()->set_kind(kind);
  message.mutable_error()->set_message("conformance: this error is part of the trial");
  message.mutable_error()->set_permanent(permanent);
  say(message);
  peer_.end_sending();
}

bool Conversation::until(const std::function<bool()>& holds, const std::string& kind, const std::string& awaited) {
  auto most = Clock::now() + patience_;
  for (auto seen = progress_; !holds();) {
    if (progress_ != seen) most = Clock::now() + patience_;
    seen = progress_;
    if (step(most)) continue;
    if (!kind.empty())
      findings_.wrong(kind, (closed_ ? "the client closed the connection" : "nothing came") +
                                std::string(" while this was awaited: ") + awaited);
    return false;
  }
  return true;
}

bool Conversation::settle() {
  v1::ServerMessage message;
  message.mutable_ping()->set_nonce(++nonce_);
  say(message);
  return until([&] { return pongs_.contains(nonce_); }, closed_ ? "" : "pong", "the Pong to a Ping, with its nonce");
}

void Conversation::listen(Clock::duration most) {
  const auto until = Clock::now() + most;
  while (step(until)) {
  }
}

/// Deals with one message; false: none came in time, or the client has gone.
bool Conversation::step(Clock::time_point until) {
  if (closed_) return false;
  const auto message = peer_.read(until);
  if (message) {
    observe(*message);
    return true;
  }
  switch (peer_.trouble()) {
    case Peer::Trouble::bad_frame:
      findings_.wrong("frame", peer_.words());
      closed_ = true;
      return false;
    case Peer::Trouble::no_message: findings_.wrong("frame", "a frame holds no RobotMessage"); return true;
    case Peer::Trouble::closed: closed_ = true; return false;
    default: return false;
  }
}

void Conversation::observe(const v1::RobotMessage& message) {
  using Body = v1::RobotMessage;
  findings_.check(!goodbye_, "after-goodbye", "a message comes after the Goodbye");
  findings_.check(welcomed_, "before-welcome", "a message comes before the Welcome");
  switch (message.body_case()) {
    case Body::kKeyframe: backlog_ = message.backlog(); return on_keyframe(message.keyframe());
    case Body::kCloudChunk: return on_chunk(message.cloud_chunk());
    case Body::kSubmapUnavailable: return on_unavailable(message.submap_unavailable());
    case Body::kGoodbye: return on_goodbye(message.goodbye());
    case Body::kPing: return pong(message.ping());
    case Body::kPong:
      findings_.check(
          message.pong().nonce() > 1000 && message.pong().nonce() <= nonce_, "pong",
          "a Pong of nonce " + std::to_string(message.pong().nonce()) + ", the Ping had " + std::to_string(nonce_));
      pongs_.insert(message.pong().nonce());
      return;
    case Body::kTrigger: return;
    case Body::kHello: return findings_.wrong("hello-twice", "a second hello on one connection");
    case Body::kProbe:
    case Body::kTakeOver: return findings_.wrong("spare", "a Probe or TakeOver, though no Welcome allowed a spare");
    default: findings_.wrong("body", "a RobotMessage without a body that protocol v1 knows: the server refuses it");
  }
}

void Conversation::pong(const v1::Ping& ping) {
  v1::ServerMessage message;
  message.mutable_pong()->set_nonce(ping.nonce());
  say(message);
}

void Conversation::on_keyframe(const v1::Keyframe& keyframe) {
  const auto sequence = keyframe.sequence();
  ++progress_;
  findings_.check(!held_, "hold", keyframe_name(sequence) + " comes while the station holds the robot");
  if (last_ == durable_ && sequence != last_ + 1 && sequence <= station_.last_keyframe + 1)
    findings_.wrong("resume", "after " + std::to_string(last_) + " durable ones it goes on with " +
                                  keyframe_name(sequence) + ", not with the one behind");
  else
    findings_.check(
        sequence == last_ + 1, "sequence",
        keyframe_name(sequence) + " comes after " + std::to_string(last_) + ": numbers are to have no holes");
  last_ = sequence;
  station_.last_keyframe = std::max(station_.last_keyframe, sequence);
  findings_.check(sequence - std::min(sequence, durable_) <= keyframes_on_their_way, "window",
                  keyframe_name(sequence) + " comes while only " + std::to_string(durable_) +
                      " are acknowledged: 64 may be on their way");
  judge_.keyframe(keyframe);
}

void Conversation::on_chunk(const v1::CloudChunk& chunk) {
  const auto sequence = chunk.sequence();
  ++progress_;
  const std::string name = cloud_name(sequence);
  findings_.check(!held_, "hold", "a chunk comes while the station holds the robot: " + name);
  findings_.check(sequence >= 1 && sequence <= last_, "cloud-early", name + " comes before its keyframe");
  findings_.check(!chunk.data().empty() && chunk.data().size() <= limits::chunk_bytes, "chunk-size",
                  name + ": a chunk of " + std::to_string(chunk.data().size()) + " bytes, 1 to 8192 are allowed");
  findings_.check(judge_.policy() != CloudPolicy::never, "unasked-cloud", name + " comes, though the policy is NEVER");
  findings_.check(judge_.policy() == CloudPolicy::all || asked_.contains(sequence), "unasked-cloud",
                  name + " was not asked for, and the policy is not ALL");
  findings_.check(!station_.refused.contains(sequence), "refused-again", name + " was refused and comes again");
  if (chunk.offset() == 0) open_[sequence] = {chunk.total_bytes(), {}};
  auto open = open_.find(sequence);
  const bool follows = open != open_.end() && chunk.offset() == open->second.bytes.size() &&
                       chunk.total_bytes() == open->second.total &&
                       chunk.offset() + std::uint64_t{chunk.data().size()} <= chunk.total_bytes();
  if (!follows && skipped_.contains(sequence)) return;
  findings_.check(follows, "chunk-offset",
                  name + ": a chunk at " + std::to_string(chunk.offset()) + " of " +
                      std::to_string(chunk.total_bytes()) + " does not follow what came before it on this connection");
  if (!follows) return void(skipped_.insert(sequence));
  open->second.bytes += chunk.data();
  findings_.check(open_.size() <= 2, "open-clouds", "more than two clouds are on their way in pieces");
  if (open->second.bytes.size() < chunk.total_bytes()) return;
  const std::string encoded = std::move(open->second.bytes);
  open_.erase(open);
  on_whole(sequence, encoded);
}

void Conversation::on_whole(std::uint64_t sequence, const std::string& encoded) {
  judge_.cloud(sequence, encoded);
  unacknowledged_.push_back(sequence);
  findings_.check(unacknowledged_.size() <= clouds_on_their_way, "clouds-window",
                  "more than 16 clouds are wholly sent and not acknowledged");
  if (!asked_.contains(sequence)) acknowledge_cloud(sequence);  // in the background: as they come
  answered(sequence);
}

void Conversation::on_unavailable(const v1::SubmapUnavailable& message) {
  for (const auto sequence : message.sequences()) {
    findings_.check(asked_.contains(sequence), "unavailable",
                    cloud_name(sequence) + " was not asked for, and is said not to come");
    const bool may_be_gone = station_.refused.contains(sequence) || station_.acknowledged.contains(sequence);
    findings_.check(judge_.points_of(sequence) == 0 || judge_.policy() == CloudPolicy::never || may_be_gone,
                    "unavailable",
                    cloud_name(sequence) + " will not come, says the client, though its keyframe has points");
    std::erase(requested_, sequence);
    answered_.insert(sequence);
  }
}

/// A cloud that is asked for comes in its turn; what cannot come at all may be said at once.
void Conversation::answered(std::uint64_t sequence) {
  answered_.insert(sequence);
  const auto at = std::find(requested_.begin(), requested_.end(), sequence);
  if (at == requested_.end()) return;  // of its own accord
  findings_.check(at == requested_.begin() || judge_.policy() == CloudPolicy::all, "request-order",
                  cloud_name(sequence) + " comes before that of keyframe " + std::to_string(requested_.front()) +
                      ", which was asked for first");
  requested_.erase(at);
}

void Conversation::on_goodbye(const v1::Goodbye& goodbye) {
  goodbye_ = true;
  findings_.check(!goodbye.complete() || (durable_ >= last_ && backlog_ == 0), "goodbye",
                  "a complete Goodbye, though only " + std::to_string(durable_) + " of " + std::to_string(last_) +
                      " keyframes are acknowledged");
  findings_.check(!goodbye.complete() || judge_.policy() != CloudPolicy::all || unacknowledged_.empty(), "goodbye",
                  "a complete Goodbye, though a cloud is not acknowledged");
}

}  // namespace headframe::conformance
