#include "server/net/robot_connection.hpp"

#include <spdlog/spdlog.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>

#include "common/security/tls.hpp"
#include "common/wire/lossy_link.hpp"
#include "server/security/relay_header.hpp"
#include "server/security/relayed_peer.hpp"

namespace headframe {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

constexpr std::size_t most_drained_bytes = 4 << 20;  // until then: who goes on sending has had its chance

constexpr unsigned char tls_handshake_record = 0x16;

boost::asio::ip::address peer_of(const tcp::socket& socket) {
  error_code gone;
  return socket.remote_endpoint(gone).address();
}

}  // namespace

RobotConnection::RobotConnection(tcp::socket socket, SessionHub& hub, const Entrance& entrance,
                                 const RobotLimits& limits)
    : stream_(std::move(socket)),
      from_(peer_of(stream_.socket())),
      timer_(stream_.get_executor()),
      hub_(hub),
      entrance_(entrance),
      limits_(limits),
      protocol_(limits, Clock::now()) {}

template <class Action>
void RobotConnection::on_strand(Action action) {
  boost::asio::post(stream_.get_executor(), [self = shared_from_this(), action = std::move(action)]() mutable {
    if (self->dropped_) return;
    action(*self);
    self->flush();
  });
}

void RobotConnection::start() {
  on_strand([](RobotConnection& self) {
    error_code ignored;
    self.stream_.socket().set_option(tcp::no_delay(true), ignored);
    expect_losses(self.stream_.socket().native_handle());  // acks must come through
    self.meet();
    self.tick();
  });
}

/// Who speaks first? TLS begins with a handshake record. Seeing that before reading it, we can tell a robot that took
/// the wrong door so in the language that it speaks.
void RobotConnection::meet() {
  async_first_byte(stream_.socket(), [self = shared_from_this()](std::optional<unsigned char> first) {
    if (!first || self->dropped_) return self->drop();
    if (!self->relayed_ && *first == relay_first_byte) return self->meet_relay();
    const bool speaks_tls = *first == tls_handshake_record;
    if (speaks_tls && self->entrance_.tls) return self->shake_hands();
    if (!speaks_tls && self->entrance_.tls)
      self->protocol_.fail(v1::ERROR_KIND_REFUSED, "this port takes TLS only: connect without --insecure", true);
    if (speaks_tls && !self->entrance_.tls)
      self->protocol_.fail(v1::ERROR_KIND_REFUSED, "a TLS client: this server runs with --insecure, in the clear",
                           true);
    self->begin();
  });
}

/// The one who is met after it is the robot, and its address counts.
void RobotConnection::meet_relay() {
  relayed_ = true;
  async_read_relay_header(stream_.socket(), entrance_.relay_key,
                          [self = shared_from_this()](const Result<boost::asio::ip::address>& client) {
                            if (self->dropped_) return;
                            if (!client) self->note(client.error().message);
                            if (!client) return self->drop();
                            self->from_ = *client;
                            self->meet();
                          });
}

void RobotConnection::shake_hands() {
  stream_.async_handshake(*entrance_.tls, boost::asio::ssl::stream_base::server,
                          [self = shared_from_this()](error_code error) {
                            if (!error) return self->begin();
                            self->note("no TLS: " + tls_trouble(error));
                            self->drop();
                          });
}

void RobotConnection::begin() {
  if (dropped_ || begun_) return;
  begun_ = true;
  flush();
  read();
}

/// One line in the log; of strangers who keep coming only some.
void RobotConnection::note(const std::string& what) const {
  if (admitted_ || !entrance_.gate || entrance_.gate->worth_a_line(from_, Clock::now()))
    spdlog::warn("robot connection from {} ended: {}", from_.to_string(), what);
}

void RobotConnection::shut() {
  on_strand([](RobotConnection& self) { self.drop(); });
}

bool RobotConnection::crowded() const {
  return undurable_bytes_ > static_cast<std::size_t>(limits_.undurable_mib) * 1024 * 1024;
}

void RobotConnection::read() {
  if (!begun_ || deciding_ || checking_ || reading_ || dropped_) return;
  const bool was_held = std::exchange(held_back_, crowded() && !protocol_.ended());
  if (held_back_ && !was_held) ++hub_.counts().held_back;
  if (held_back_) return;
  reading_ = true;
  stream_.async_read_some(boost::asio::buffer(input_), [self = shared_from_this()](error_code error, std::size_t n) {
    self->reading_ = false;
    if (error) return self->drop();
    self->on_bytes(n);
    self->flush();
    self->read();
  });
}

void RobotConnection::on_bytes(std::size_t bytes) {
  if (protocol_.ended()) {  // read only so that the robot gets our last word before the socket closes
    drained_bytes_ += bytes;
    if (drained_bytes_ > most_drained_bytes) drop();
    return;
  }
  protocol_.receive({input_.data(), bytes}, Clock::now());
  take_events();
  if (session_ != 0) hub_.received(session_, bytes);
}

void RobotConnection::take_events() {
  while (!checking_) {
    auto event = protocol_.next();
    if (!event) return;
    if (const auto* hello = std::get_if<HelloReceived>(&*event)) {
      greet(hello->hello);
      continue;
    }
    if (const auto* probe = std::get_if<ProbeReceived>(&*event)) {
      protocol_.resume(hub_.durable_keyframes(session_), !probe->keyframe_follows);
      continue;
    }
    if (auto* cloud = std::get_if<CloudArrived>(&*event))
      check(std::move(*cloud));
    else
      take(std::move(*event));
  }
}

void RobotConnection::take(RobotEvent event) {
  undurable_bytes_ += SessionHub::stored_bytes(event);
  hub_.take(session_, std::move(event), shared_from_this());
}

/// Decoding takes long, and how long the robot chooses: not on a thread that serves others. What the robot says next
/// waits, so that the order stays.
void RobotConnection::check(CloudArrived cloud) {
  checking_ = true;
  hub_.work_for(session_, [self = shared_from_this(), cloud = std::move(cloud)]() mutable {
    auto decodes = RobotProtocol::check(cloud);
    self->on_strand([cloud = std::move(cloud), decodes = std::move(decodes)](RobotConnection& me) mutable {
      me.checking_ = false;
      me.take(me.protocol_.checked(std::move(cloud), decodes));
      me.take_events();
      me.read();
    });
  });
}

void RobotConnection::greet(const Hello& hello) {
  if (!entrance_.gate) return admit(hello);
  deciding_ = true;
  const Credential shown{hello.token, hello.enrolment_code};
  entrance_.gate->admit(hello.session.robot, shown, from_, Clock::now(),
                        [self = shared_from_this(), hello](const Result<void>& decided) {
                          self->on_strand([hello, decided](RobotConnection& me) {
                            me.deciding_ = false;
                            decided ? me.admit(hello) : me.refuse(decided.error());
                            me.take_events();
                            me.read();
                          });
                        });
}

void RobotConnection::admit(const Hello& hello) {
  if (protocol_.ended()) return;  // it took too long
  const auto admitted = hub_.admit(hello, shared_from_this());
  if (!admitted) {
    ++hub_.counts().refused;
    return refuse(admitted.error());
  }
  session_ = admitted->session;
  admitted_ = true;
  // Revoked since the gate opened: the hub did not know this connection then, so it is for us to end it.
  if (entrance_.gate && !entrance_.gate->holds(hello.session.robot, hello.token))
    return refuse({ErrorCode::refused, "robot " + hello.session.robot + ": it was revoked"});
  protocol_.welcome(admitted->durable);
  if (admitted->transform) protocol_.update_transform(admitted->transform);
}

void RobotConnection::refuse(const Error& error) {
  const bool passes = error.code != ErrorCode::refused;
  protocol_.fail(passes ? v1::ERROR_KIND_OVERLOADED : v1::ERROR_KIND_REFUSED, error.message, !passes);
}

void RobotConnection::settled(std::size_t bytes, const Result<void>& result) {
  on_strand([bytes, result](RobotConnection& self) {
    self.undurable_bytes_ -= bytes;
    if (!result) self.not_stored(result.error());
    self.read();
  });
}

/// A store that is broken holds the robot (SessionHub::policy) and acknowledges nothing: ending the connection would
/// only bring it back.
void RobotConnection::not_stored(const Error& error) {
  const bool broken = error.code == ErrorCode::bad_input || error.code == ErrorCode::internal;
  const bool refused = error.code == ErrorCode::refused;
  if (!broken)
    protocol_.fail(refused ? v1::ERROR_KIND_REFUSED : v1::ERROR_KIND_OVERLOADED, "not stored: " + error.message,
                   refused);
}

void RobotConnection::keyframes_durable(std::uint64_t sequence) {
  on_strand([sequence](RobotConnection& self) { self.protocol_.keyframes_durable(sequence); });
}

void RobotConnection::poses_durable(std::uint64_t update) {
  on_strand([update](RobotConnection& self) { self.protocol_.poses_durable(update); });
}

void RobotConnection::cloud_durable(std::uint64_t sequence) {
  on_strand([sequence](RobotConnection& self) { self.protocol_.cloud_durable(sequence); });
}

void RobotConnection::cloud_refused(std::uint64_t sequence, const std::string& reason) {
  on_strand([=](RobotConnection& self) { self.protocol_.refuse_cloud(sequence, reason); });
}

void RobotConnection::request_submap(const std::vector<std::uint64_t>& sequences) {
  on_strand([sequences](RobotConnection& self) { self.protocol_.request_submap(sequences); });
}

void RobotConnection::update_transform(std::shared_ptr<const TransformPages> pages) {
  on_strand([pages = std::move(pages)](RobotConnection& self) { self.protocol_.update_transform(pages); });
}

void RobotConnection::tell_localization(std::shared_ptr<const std::string> payload) {
  on_strand([payload = std::move(payload)](RobotConnection& self) { self.protocol_.tell_localization(payload); });
}

void RobotConnection::tell_surroundings(SurroundingsKind kind, std::shared_ptr<const std::string> payload) {
  on_strand(
      [kind, payload = std::move(payload)](RobotConnection& self) { self.protocol_.tell_surroundings(kind, payload); });
}

void RobotConnection::stand_by() {
  on_strand([](RobotConnection& self) { self.protocol_.stand_by(); });
}

void RobotConnection::close(v1::ErrorKind kind, const std::string& message, bool permanent) {
  on_strand([=](RobotConnection& self) { self.protocol_.fail(kind, message, permanent); });
}

}  // namespace headframe
