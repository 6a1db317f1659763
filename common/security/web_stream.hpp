#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/teardown.hpp>
#include <memory>
#include <utility>

namespace headframe {

/// A TCP connection with timeouts for HTTP and WebSocket, unencrypted until a TLS handshake is begun, for use with
/// Beast. Callbacks only. Not thread safe: use it from one strand, like a socket.
///
/// HTTP and WebSocket mark the end of a message themselves (a length, or chunks), so TLS's close_notify is neither sent
/// nor awaited: closing works as for plain TCP.
class WebStream {
 public:
  using next_layer_type = boost::beast::tcp_stream;
  using executor_type = next_layer_type::executor_type;

  explicit WebStream(boost::asio::ip::tcp::socket socket)
      : tcp_(std::make_unique<next_layer_type>(std::move(socket))) {}
  explicit WebStream(boost::asio::io_context& io) : tcp_(std::make_unique<next_layer_type>(io)) {}

  /// For timeouts, the socket and closing.
  next_layer_type& next_layer() { return *tcp_; }
  const next_layer_type& next_layer() const { return *tcp_; }
  executor_type get_executor() { return tcp_->get_executor(); }
  bool is_tls() const { return tls_ != nullptr; }

  /// Begins TLS. `context` must outlive this object. The returned pointer allows settings for the peer before the
  /// handshake; it is valid as long as this object.
  SSL* begin_tls(boost::asio::ssl::context& context) {
    tls_ = std::make_unique<Tls>(*tcp_, context);
    return tls_->native_handle();
  }
  /// Call after begin_tls(). `received`: bytes of the peer's first message that were read already. Handler:
  /// void(error_code, std::size_t).
  template <class Buffers, class Handler>
  void async_handshake(boost::asio::ssl::stream_base::handshake_type side, const Buffers& received, Handler handler) {
    tls_->async_handshake(side, received, std::move(handler));
  }

  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler handler) {
    if (tls_)
      tls_->async_read_some(buffers, std::move(handler));
    else
      tcp_->async_read_some(buffers, std::move(handler));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler handler) {
    if (tls_)
      tls_->async_write_some(buffers, std::move(handler));
    else
      tcp_->async_write_some(buffers, std::move(handler));
  }

 private:
  using Tls = boost::asio::ssl::stream<next_layer_type&>;
  std::unique_ptr<next_layer_type> tcp_;
  std::unique_ptr<Tls> tls_;
};

/// Called by Beast to end the connection under a WebSocket.
template <class Handler>
void async_teardown(boost::beast::role_type role, WebStream& stream, Handler&& handler) {
  using boost::beast::websocket::async_teardown;
  async_teardown(role, stream.next_layer().socket(), std::forward<Handler>(handler));
}
inline void teardown(boost::beast::role_type role, WebStream& stream, boost::beast::error_code& code) {
  using boost::beast::websocket::teardown;
  teardown(role, stream.next_layer().socket(), code);
}

}  // namespace headframe
