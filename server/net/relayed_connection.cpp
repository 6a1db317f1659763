#include "server/net/relayed_connection.hpp"

#include <boost/asio/buffer.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/write.hpp>
#include <utility>

#include "common/wire/lossy_link.hpp"
#include "server/security/relay_header.hpp"

namespace headframe {
namespace {

namespace net = boost::asio;
using boost::system::error_code;
using net::ip::tcp;

void make_lively(tcp::socket& socket) {
  error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  socket.set_option(net::socket_base::keep_alive(true), ignored);
  expect_losses(socket.native_handle());  // acks must come through
}

}  // namespace

RelayedConnection::RelayedConnection(tcp::socket client, std::string header, const RelayLimits& limits)
    : client_(std::move(client)),
      server_(client_.get_executor()),
      resolver_(client_.get_executor()),
      timer_(client_.get_executor()),
      to_send_(std::move(header)),
      limits_(limits) {}

/// What the client says first is waited for: where several servers pass connections on to each other for a moment, or
/// one to itself, a connection that was passed on already would go round for ever.
void RelayedConnection::start(const Endpoint& target, Ended ended) {
  ended_ = std::move(ended);
  end_after(limits_.speak_within);
  up_.bytes.resize(limits_.buffer_bytes);
  client_.async_read_some(net::buffer(up_.bytes), [self = shared_from_this(), target](error_code error, std::size_t n) {
    if (error || !self->ended_) return self->end();
    if (static_cast<unsigned char>(self->up_.bytes[0]) == relay_first_byte) return self->end(true);
    self->has_spoken_ = true;
    self->to_send_.append(self->up_.bytes, 0, n);
    self->reach(target);
  });
}

/// An address is taken as it is; a name is looked up on a thread of Asio's.
void RelayedConnection::reach(const Endpoint& target) {
  end_after(limits_.connect_within);
  error_code is_name;
  const auto address = net::ip::make_address(target.host, is_name);
  const std::string port = std::to_string(target.port);
  if (!is_name) return connect(tcp::resolver::results_type::create({address, target.port}, target.host, port));
  resolver_.async_resolve(target.host, port, tcp::resolver::numeric_service,
                          [self = shared_from_this()](error_code error, const tcp::resolver::results_type& found) {
                            error ? self->end() : self->connect(found);
                          });
}

void RelayedConnection::connect(const tcp::resolver::results_type& found) {
  if (!ended_) return;
  net::async_connect(server_, found, [self = shared_from_this()](error_code error, const tcp::endpoint&) {
    error ? self->end() : self->begin();
  });
}

void RelayedConnection::begin() {
  if (!ended_) return;
  timer_.cancel();
  make_lively(client_);
  make_lively(server_);
  net::async_write(server_, net::buffer(to_send_), [self = shared_from_this()](error_code error, std::size_t) {
    self->to_send_ = {};
    error ? self->end() : self->pass(self->up_);
  });
  pass(down_);
}

void RelayedConnection::pass(Way& way) {
  way.bytes.resize(limits_.buffer_bytes);
  way.from.async_read_some(net::buffer(way.bytes), [self = shared_from_this(), &way](error_code error, std::size_t n) {
    if (error == net::error::eof) return self->pass_on_end(way);
    if (error) return self->end();
    net::async_write(way.to, net::buffer(way.bytes, n),
                     [self, &way](error_code fault, std::size_t) { fault ? self->end() : self->pass(way); });
  });
}

void RelayedConnection::pass_on_end(Way& way) {
  way.ended = true;
  if (up_.ended && down_.ended) return end();
  error_code ignored;
  way.to.shutdown(tcp::socket::shutdown_send, ignored);
  end_after(limits_.half_closed_for);
}

void RelayedConnection::end_after(std::chrono::seconds time) {
  timer_.expires_after(time);
  timer_.async_wait([self = shared_from_this()](error_code cancelled) {
    if (!cancelled) self->end();
  });
}

void RelayedConnection::end(bool came_back) {
  const auto ended = std::exchange(ended_, nullptr);
  if (!ended) return;
  error_code ignored;
  resolver_.cancel();
  timer_.cancel();
  client_.close(ignored);
  server_.close(ignored);
  ended(came_back);
}

}  // namespace headframe
