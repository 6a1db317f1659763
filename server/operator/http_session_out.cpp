// The sending half of HttpSession: responses, whole or in pieces, and how the connection ends.

#include <poll.h>

#include <array>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/write.hpp>
#include <sstream>

#include "server/operator/http_session.hpp"

namespace headframe {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;

constexpr std::size_t linger_bytes = 1024 * 1024;

/// Allows scripts only from this server, and inline ones; a policy in the page itself then allows only its own inline
/// script (vite.config.js).
constexpr const char* page_policy =
    "default-src 'self'; script-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'";
constexpr const char* other_policy = "default-src 'none'; frame-ancestors 'none'";

template <class Response>
void set_common(Response& response, std::string_view content_type, bool keep_alive) {
  response.set(http::field::server, "headframe");
  response.set(http::field::content_type, beast::string_view(content_type.data(), content_type.size()));
  response.set(http::field::cache_control, "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  const bool is_page = content_type.substr(0, 9) == "text/html";
  response.set("Content-Security-Policy", is_page ? page_policy : other_policy);
  response.keep_alive(keep_alive);
}

}  // namespace

void HttpSession::send(Ready ready) {
  auto response = std::make_shared<http::response<http::string_body>>();
  response->version(11);
  response->result(static_cast<unsigned>(ready.status));
  set_common(*response, ready.content_type, keep_alive_);
  if (ready.gzip) response->set(http::field::content_encoding, "gzip");
  if (!ready.allow.empty()) response->set(http::field::allow, ready.allow);
  if (!ready.location.empty()) response->set(http::field::location, ready.location);
  if (ready.page != Ready::Page::as_it_is && shared_->asks_token)
    response->set(http::field::set_cookie, page_cookie(ready.page));
  if (ready.bearer) response->set(http::field::www_authenticate, "Bearer");
  response->body() = std::move(ready.body);
  response->prepare_payload();
  response_ = response;
  allow(shared_->limits.write_s);
  http::async_write(stream_, *response, [self = shared_from_this()](Code code, std::size_t) {
    self->response_.reset();
    code ? self->finish() : self->on_written();
  });
}

/// Sends the answer when it is available; closes the connection if the client disconnects before.
void HttpSession::answer_later(const Later& later) {
  watch_client();
  const auto answer = [weak = weak_from_this()](Ready ready) {
    const auto self = weak.lock();
    if (!self) return;
    net::post(self->stream_.get_executor(), [self, ready = std::move(ready)]() mutable {
      if (!self->tcp().socket().is_open()) return;
      self->look_.cancel();
      self->send(std::move(ready));
    });
  };
  if (!later.on_disk) return later.start(answer);
  net::post(shared_->disk, [start = later.start, answer] { start(answer); });
}

void HttpSession::pull() {
  if (client_gone()) return finish();
  net::post(shared_->disk, [self = shared_from_this()] {
    Piece piece;
    try {
      piece = self->body_->body->next();
    } catch (const std::exception& exception) {
      piece = failure(ErrorCode::internal, exception.what());
    }
    net::post(self->stream_.get_executor(),
              [self, piece = std::move(piece)]() mutable { self->on_piece(std::move(piece)); });
  });
}

void HttpSession::on_piece(Piece piece) {
  if (!tcp().socket().is_open()) return finish();
  if (!piece) {
    if (head_sent_) return finish();  // without the last chunk, so the client notices that the body is incomplete
    Error error = piece.error();
    body_.reset();
    const bool ours = error.code == ErrorCode::bad_input;  // our stored data is bad, not the request
    return send(ours ? error_reply(500, error) : error_reply(error));
  }
  if (*piece && (*piece)->empty()) return pull();
  write_piece(std::move(*piece));
}

void HttpSession::write_piece(std::optional<std::string> piece) {
  std::ostringstream head;
  const bool last = !piece;
  if (!std::exchange(head_sent_, true)) {
    left_ = body_->body->total_bytes();
    http::response<http::empty_body> response(http::status::ok, 11);
    set_common(response, body_->content_type, keep_alive_);
    left_ ? response.content_length(*left_) : response.chunked(true);
    head << response.base();
  }
  if (left_) {
    if (last ? *left_ > 0 : piece->size() > *left_) return finish();  // a wrong length: it must not look complete
    *left_ -= last ? 0 : piece->size();
  } else {
    head << std::hex << (last ? 0 : piece->size()) << "\r\n";
  }
  head_ = head.str();
  piece_ = std::move(piece).value_or("");
  const std::array<net::const_buffer, 3> buffers{net::buffer(head_), net::buffer(piece_),
                                                 net::buffer("\r\n", left_ ? 0 : 2)};
  allow(shared_->limits.write_s);
  net::async_write(stream_, buffers, [self = shared_from_this(), last](Code code, std::size_t) {
    if (code) return self->finish();
    if (!last) return self->pull();
    self->body_.reset();
    self->on_written();
  });
}

void HttpSession::on_written() { keep_alive_ ? read() : linger(); }

/// Closes the connection so that the client can still read the response: received data is discarded for a while,
/// because otherwise the kernel would reset the connection.
void HttpSession::linger() {
  Code ignored;
  tcp().socket().shutdown(net::ip::tcp::socket::shutdown_send, ignored);
  allow(linger_s);
  drain(0);
}

void HttpSession::drain(std::size_t drained_bytes) {
  buffer_.clear();
  stream_.async_read_some(buffer_.prepare(4096),
                          [self = shared_from_this(), drained_bytes](Code code, std::size_t bytes) {
                            if (code || drained_bytes + bytes > linger_bytes) return self->finish();
                            self->drain(drained_bytes + bytes);
                          });
}

void HttpSession::finish() {
  if (handed_over_) return;
  look_.cancel();
  tcp().close();
  shared_->forget(shared_from_this());
}

void HttpSession::watch_client() {
  look_.expires_after(look_every);
  look_.async_wait([self = shared_from_this()](Code ended) {
    if (ended || self->handed_over_) return;
    self->client_gone() ? self->finish() : self->watch_client();
  });
}

/// Whether the client has closed the connection, even if unread data such as TLS's close notification precedes that.
bool HttpSession::client_gone() {
  pollfd look{tcp().socket().native_handle(), POLLRDHUP, 0};
  return ::poll(&look, 1, 0) > 0 && (look.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
}

}  // namespace headframe
