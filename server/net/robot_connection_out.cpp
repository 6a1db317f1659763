// What a connection sends, and how it ends.
#include <boost/asio/buffer.hpp>
#include <boost/asio/write.hpp>

#include "server/net/robot_connection.hpp"

namespace headframe {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

constexpr auto tick_every = std::chrono::milliseconds(100);
constexpr auto farewell = std::chrono::seconds(2);  // for the robot to read the last error and close

}  // namespace

void RobotConnection::flush() {
  if (!begun_ || writing_ || dropped_ || finishing_) return;
  output_ = protocol_.take_output();
  if (output_.empty()) {
    if (protocol_.ended()) after_last_word();
    return;
  }
  writing_ = true;
  write_began_ = Clock::now();
  hub_.counts().sent_bytes += output_.size();
  boost::asio::async_write(stream_, boost::asio::buffer(output_),
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
  stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
  note(protocol_.reason());
  read();
}

void RobotConnection::tick() {
  const auto now = Clock::now();
  protocol_.tick(now, reading_);
  if (!begun_ && protocol_.ended()) {
    if (entrance_.tls) {
      note("no TLS handshake in time");
      return drop();
    }
    begin();  // in the clear it can be told why
  }
  if (protocol_.welcomed()) {
    tell_policy();
    hub_.look_around(session_, this);
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

void RobotConnection::tell_policy() {
  const LinkPolicy policy = hub_.policy_of(session_);
  if (policy == told_) return;
  told_ = policy;
  protocol_.tell_policy(policy);
}

void RobotConnection::drop() {
  if (dropped_) return;
  dropped_ = true;
  error_code ignored;
  stream_.socket().close(ignored);
  timer_.cancel();
  if (session_ != 0) hub_.left(session_, this);
}

}  // namespace headframe
