#include "server/net/robot_connection.hpp"

#include <netinet/tcp.h>
#include <spdlog/spdlog.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>

namespace headframe {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

constexpr auto tick_every = std::chrono::milliseconds(100);
constexpr auto farewell = std::chrono::seconds(2);  // for the robot to read the last error and close

}  // namespace

RobotConnection::RobotConnection(tcp::socket socket, SessionHub& hub, const RobotLimits& limits)
    : socket_(std::move(socket)),
      timer_(socket_.get_executor()),
      hub_(hub),
      limits_(limits),
      protocol_(limits, Clock::now()) {}

template <class Action>
void RobotConnection::on_strand(Action action) {
  boost::asio::post(socket_.get_executor(), [self = shared_from_this(), action = std::move(action)]() mutable {
    if (self->dropped_) return;
    action(*self);
    self->flush();
  });
}

void RobotConnection::start() {
  on_strand([](RobotConnection& self) {
    error_code ignored;
    self.socket_.set_option(tcp::no_delay(true), ignored);
    using ThinLinearTimeouts = boost::asio::detail::socket_option::boolean<IPPROTO_TCP, TCP_THIN_LINEAR_TIMEOUTS>;
    self.socket_.set_option(ThinLinearTimeouts(true), ignored);  // lossy links: acks are few and must come through
    self.read();
    self.tick();
  });
}

void RobotConnection::start_refusing(const std::string& why) {
  on_strand([why](RobotConnection& self) {
    self.protocol_.fail(v1::ERROR_KIND_OVERLOADED, why, false);
    self.read();
    self.tick();
  });
}

void RobotConnection::shut() {
  on_strand([](RobotConnection& self) { self.drop(); });
}

bool RobotConnection::crowded() const {
  return undurable_bytes_ > static_cast<std::size_t>(limits_.undurable_mib) * 1024 * 1024;
}

void RobotConnection::read() {
  if (reading_ || dropped_) return;
  const bool was_held = std::exchange(held_back_, crowded() && !protocol_.ended());
  if (held_back_ && !was_held) ++hub_.counts().held_back;
  if (held_back_) return;
  reading_ = true;
  socket_.async_read_some(boost::asio::buffer(input_), [self = shared_from_this()](error_code error, std::size_t n) {
    self->reading_ = false;
    if (error) return self->drop();
    self->on_bytes(n);
    self->flush();
    self->read();
  });
}

void RobotConnection::on_bytes(std::size_t bytes) {
  if (protocol_.ended()) return;  // read only so that the robot gets our last word before the socket closes
  protocol_.receive({input_.data(), bytes}, Clock::now());
  while (auto event = protocol_.next()) {
    if (const auto* hello = std::get_if<HelloReceived>(&*event)) {
      greet(hello->hello);
      continue;
    }
    undurable_bytes_ += SessionHub::stored_bytes(*event);
    hub_.take(session_, std::move(*event), shared_from_this());
  }
  if (session_ != 0) hub_.received(session_, bytes);
}

void RobotConnection::greet(const Hello& hello) {
  const auto admitted = hub_.admit(hello, shared_from_this());
  if (!admitted) ++hub_.counts().refused;
  if (!admitted) return protocol_.fail(v1::ERROR_KIND_REFUSED, admitted.error().message, true);
  session_ = admitted->session;
  protocol_.welcome(admitted->durable);
  if (admitted->transform) protocol_.update_transform(admitted->transform);
}

void RobotConnection::flush() {
  if (writing_ || dropped_ || finishing_) return;
  output_ = protocol_.take_output();
  if (output_.empty()) {
    if (protocol_.ended()) after_last_word();
    return;
  }
  writing_ = true;
  write_began_ = Clock::now();
  boost::asio::async_write(socket_, boost::asio::buffer(output_),
                           [self = shared_from_this()](error_code error, std::size_t) {
                             self->writing_ = false;
                             if (error) return self->drop();
                             self->flush();
                           });
}

/// Closing with unread bytes would reset the connection, and the robot would never see why: let it close first.
void RobotConnection::after_last_word() {
  finishing_ = true;
  ++hub_.counts().failed;
  finish_began_ = Clock::now();
  error_code ignored;
  socket_.shutdown(tcp::socket::shutdown_send, ignored);
  spdlog::warn("robot connection ended: {}", protocol_.reason());
  read();
}

void RobotConnection::tick() {
  const auto now = Clock::now();
  protocol_.tick(now, reading_);
  if (const LinkPolicy policy = hub_.policy(); protocol_.welcomed() && policy != told_) {
    told_ = policy;
    protocol_.tell_policy(policy);
  }
  const bool stuck = writing_ && std::chrono::duration<double>(now - write_began_).count() >= limits_.write_s;
  if (stuck) ++hub_.counts().stuck;
  if (stuck || (finishing_ && now - finish_began_ >= farewell)) return drop();
  flush();
  timer_.expires_after(tick_every);
  timer_.async_wait([self = shared_from_this()](error_code error) {
    if (!error && !self->dropped_) self->tick();
  });
}

void RobotConnection::drop() {
  if (dropped_) return;
  dropped_ = true;
  error_code ignored;
  socket_.close(ignored);
  timer_.cancel();
  if (session_ != 0) hub_.left(session_, this);
}

void RobotConnection::settled(std::size_t bytes, const Result<void>& result) {
  on_strand([bytes, message = result ? std::string() : result.error().message](RobotConnection& self) {
    self.undurable_bytes_ -= bytes;
    if (!message.empty()) self.protocol_.fail(v1::ERROR_KIND_OVERLOADED, "not stored: " + message, false);
    self.read();
  });
}

void RobotConnection::keyframes_durable(std::uint64_t sequence) {
  on_strand([sequence](RobotConnection& self) { self.protocol_.keyframes_durable(sequence); });
}

void RobotConnection::cloud_durable(std::uint64_t sequence) {
  on_strand([sequence](RobotConnection& self) { self.protocol_.cloud_durable(sequence); });
}

void RobotConnection::request_submap(const std::vector<std::uint64_t>& sequences) {
  on_strand([sequences](RobotConnection& self) { self.protocol_.request_submap(sequences); });
}

void RobotConnection::update_transform(std::shared_ptr<const std::string> payload) {
  on_strand([payload = std::move(payload)](RobotConnection& self) { self.protocol_.update_transform(payload); });
}

void RobotConnection::close(v1::ErrorKind kind, const std::string& message, bool permanent) {
  on_strand([=](RobotConnection& self) { self.protocol_.fail(kind, message, permanent); });
}

}  // namespace headframe
