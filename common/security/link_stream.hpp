#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <optional>
#include <utility>

namespace headframe {

/// A TCP connection, unencrypted until a TLS handshake is begun, for use with asio::async_write and async_read_some.
/// Callbacks only. Not thread safe: use it from one strand, like a socket.
///
/// Our own messages (Goodbye, ErrorReport) end a conversation, so TLS's close_notify is neither sent nor awaited:
/// closing works as for plain TCP, and a peer that is gone delays nobody.
class LinkStream {
 public:
  using Socket = boost::asio::ip::tcp::socket;
  using executor_type = Socket::executor_type;

  explicit LinkStream(Socket socket) : socket_(std::move(socket)) {}
  explicit LinkStream(boost::asio::io_context& io) : socket_(io) {}
  LinkStream(const LinkStream&) = delete;
  LinkStream& operator=(const LinkStream&) = delete;

  Socket& socket() { return socket_; }
  executor_type get_executor() { return socket_.get_executor(); }

  /// Begins TLS. `context` must outlive this object. Handler: void(error_code).
  template <class Handler>
  void async_handshake(boost::asio::ssl::context& context, boost::asio::ssl::stream_base::handshake_type side,
                       Handler handler) {
    tls_.emplace(socket_, context);
    tls_->async_handshake(side, std::move(handler));
  }

  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler handler) {
    if (tls_)
      tls_->async_read_some(buffers, std::move(handler));
    else
      socket_.async_read_some(buffers, std::move(handler));
  }

  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler handler) {
    if (tls_)
      tls_->async_write_some(buffers, std::move(handler));
    else
      socket_.async_write_some(buffers, std::move(handler));
  }

 private:
  Socket socket_;
  std::optional<boost::asio::ssl::stream<Socket&>> tls_;
};

}  // namespace headframe
