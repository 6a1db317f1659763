#include "server/operator/http_session.hpp"

#include <sys/socket.h>

#include <array>
#include <boost/asio/bind_executor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <sstream>

namespace headframe {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;

std::chrono::milliseconds duration(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

template <class Response>
void set_common(Response& response, std::string_view content_type, bool keep_alive) {
  response.set(http::field::server, "headframe");
  response.set(http::field::content_type, beast::string_view(content_type.data(), content_type.size()));
  response.set(http::field::cache_control, "no-store");
  response.keep_alive(keep_alive);
}

std::string_view text(beast::string_view view) { return {view.data(), view.size()}; }

/// A page can give a WebSocket no header: it offers the protocols "headframe" and the token.
template <class Request>
std::string credentials_of(const Request& request) {
  const std::string_view offered = text(request[http::field::sec_websocket_protocol]);
  constexpr std::string_view prefix = "headframe, ";
  if (offered.substr(0, prefix.size()) == prefix) return "Bearer " + std::string(offered.substr(prefix.size()));
  return std::string(text(request[http::field::authorization]));
}

constexpr double linger_s = 2;
constexpr std::size_t linger_bytes = 1024 * 1024;

}  // namespace

HttpSession::HttpSession(net::ip::tcp::socket socket, std::shared_ptr<HttpShared> shared, bool turn_away)
    : stream_(std::move(socket)),
      shared_(std::move(shared)),
      turn_away_(turn_away),
      buffer_(shared_->limits.header_bytes + 8192) {
  Code gone;
  from_ = stream_.socket().remote_endpoint(gone).address();
}

void HttpSession::start() {
  net::post(stream_.get_executor(), [self = shared_from_this()] { self->read(); });
}

void HttpSession::close() {
  net::post(stream_.get_executor(), [self = shared_from_this()] { self->finish(); });
}

void HttpSession::read() {
  parser_.emplace();
  parser_->header_limit(static_cast<std::uint32_t>(shared_->limits.header_bytes));
  parser_->body_limit(shared_->limits.body_bytes);
  stream_.expires_after(duration(turn_away_ ? linger_s : shared_->limits.idle_s));
  header_bytes_ = 0;
  read_header();
}

/// Piece by piece: Beast 1.74 counts its header limit anew after each complete field, so that a header could be
/// endless.
void HttpSession::read_header() {
  parser_->eager(false);
  http::async_read_some(stream_, buffer_, *parser_, [self = shared_from_this()](Code code, std::size_t parsed_bytes) {
    self->header_bytes_ += parsed_bytes;
    const bool done = self->parser_->is_header_done();
    if (!code && self->header_bytes_ + (done ? 0 : self->buffer_.size()) > self->shared_->limits.header_bytes)
      code = http::error::header_limit;
    if (code) return self->on_read(code);
    if (!done) return self->read_header();
    http::async_read(self->stream_, self->buffer_, *self->parser_,
                     [self](Code body_code, std::size_t) { self->on_read(body_code); });
  });
}

void HttpSession::on_read(Code code) {
  stream_.expires_never();
  if (code) return refuse(code);
  const auto& request = parser_->get();
  keep_alive_ = request.keep_alive();
  if (turn_away_) {
    keep_alive_ = false;
    return send(error_reply({ErrorCode::unavailable, "too many connections; close some or try again later"}));
  }
  if (auto refusal = turned_down()) return send(std::move(*refusal));
  const std::chrono::duration<double> uptime = std::chrono::steady_clock::now() - shared_->started;
  try {
    perform(route({text(request.method_string()), text(request.target()), request.body()}, shared_->station,
                  shared_->tiles, shared_->limits, uptime.count(), shared_->robots));
  } catch (const std::exception& exception) {  // of a library: ends here, with this request
    send(error_reply({ErrorCode::internal, exception.what()}));
  }
}

/// The answer to a request that lacks the operator's token.
std::optional<Ready> HttpSession::turned_down() {
  using Verdict = OperatorGuard::Verdict;
  const auto& request = parser_->get();
  if (is_public(text(request.target()))) return std::nullopt;
  const auto verdict = shared_->guard.check(credentials_of(request), from_, std::chrono::steady_clock::now());
  if (verdict == Verdict::welcome) return std::nullopt;
  if (verdict == Verdict::limited) {
    keep_alive_ = false;
    return error_reply(429, {ErrorCode::refused, "too many wrong tokens from this address; wait a minute"});
  }
  Ready refusal = error_reply(
      401, {ErrorCode::refused,
            verdict == Verdict::missing
                ? "the operator's token is missing; it is in operator.token in the server's data directory"
                : "this is not the operator's token; it is in operator.token in the server's data directory"});
  refusal.bearer = true;
  return refusal;
}

void HttpSession::refuse(Code code) {
  keep_alive_ = false;
  const OperatorLimits& limits = shared_->limits;
  if (code == http::error::end_of_stream) return linger();
  if (code == http::error::header_limit || code == http::error::buffer_overflow)
    return send(error_reply(431, {ErrorCode::refused, "the request's header is longer than " +
                                                          std::to_string(limits.header_bytes) + " bytes"}));
  if (code == http::error::body_limit)
    return send(error_reply(413, {ErrorCode::refused, "the request's body is longer than " +
                                                          std::to_string(limits.body_bytes) + " bytes"}));
  const bool unreadable = code.category() == http::make_error_code(http::error::bad_method).category();
  if (!unreadable || code == http::error::partial_message) return finish();
  send(error_reply({ErrorCode::bad_input, "this is not HTTP/1.1: " + code.message()}));
}

void HttpSession::perform(Reply reply) {
  if (auto* ready = std::get_if<Ready>(&reply)) return send(std::move(*ready));
  if (std::holds_alternative<Upgrade>(reply)) return upgrade();
  if (const auto* later = std::get_if<Later>(&reply)) return answer_later(*later);
  if (parser_->get().version() < 11)
    return send(error_reply(505, {ErrorCode::incompatible, "this resource is sent in chunks; ask with HTTP/1.1"}));
  body_ = std::make_unique<Stream>(std::move(std::get<Stream>(reply)));
  head_sent_ = false;
  pull();
}

/// The connection goes over to the event feed.
void HttpSession::upgrade() {
  const auto& request = parser_->get();
  if (!beast::websocket::is_upgrade(request))
    return send(error_reply(426, {ErrorCode::invalid_argument, "events are told over WebSocket; ask for an upgrade"}));
  if (!same_origin(text(request[http::field::origin]), text(request[http::field::host])))
    return send(error_reply({ErrorCode::refused, "a page of another origin may not listen"}));
  if (!shared_->events->take_place())
    return send(error_reply({ErrorCode::unavailable, "too many listen already; close some pages"}));
  shared_->events->serve(beast::tcp_stream(stream_.release_socket()), parser_->release());
  shared_->forget(shared_from_this());
}

void HttpSession::send(Ready ready) {
  auto response = std::make_shared<http::response<http::string_body>>();
  response->version(11);
  response->result(static_cast<unsigned>(ready.status));
  set_common(*response, ready.content_type, keep_alive_);
  if (ready.gzip) response->set(http::field::content_encoding, "gzip");
  if (!ready.allow.empty()) response->set(http::field::allow, ready.allow);
  if (ready.bearer) response->set(http::field::www_authenticate, "Bearer");
  response->body() = std::move(ready.body);
  response->prepare_payload();
  response_ = response;
  stream_.expires_after(duration(shared_->limits.write_s));
  http::async_write(stream_, *response, [self = shared_from_this()](Code code, std::size_t) {
    self->response_.reset();
    code ? self->finish() : self->on_written();
  });
}

/// Answers when the answer comes; ends when the client goes before that.
void HttpSession::answer_later(const Later& later) {
  stream_.socket().async_wait(net::ip::tcp::socket::wait_read, [self = shared_from_this()](Code code) {
    if (!code && self->client_gone()) self->finish();
  });
  later.start([weak = weak_from_this()](Ready ready) {
    const auto self = weak.lock();
    if (!self) return;
    net::post(self->stream_.get_executor(), [self, ready = std::move(ready)]() mutable {
      if (!self->stream_.socket().is_open()) return;
      Code ignored;
      self->stream_.socket().cancel(ignored);  // the wait for the client's end
      self->send(std::move(ready));
    });
  });
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
  if (!stream_.socket().is_open()) return finish();
  if (!piece) {
    if (head_sent_) return finish();  // without the last chunk: the client knows that something is missing
    Error error = piece.error();
    body_.reset();
    const bool ours = error.code == ErrorCode::bad_input;  // what is on our disk, not what was asked
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
    if (last ? *left_ > 0 : piece->size() > *left_) return finish();  // not what was promised: it must not look whole
    *left_ -= last ? 0 : piece->size();
  } else {
    head << std::hex << (last ? 0 : piece->size()) << "\r\n";
  }
  head_ = head.str();
  piece_ = std::move(piece).value_or("");
  const std::array<net::const_buffer, 3> buffers{net::buffer(head_), net::buffer(piece_),
                                                 net::buffer("\r\n", left_ ? 0 : 2)};
  stream_.expires_after(duration(shared_->limits.write_s));
  net::async_write(stream_, buffers, [self = shared_from_this(), last](Code code, std::size_t) {
    if (code) return self->finish();
    if (!last) return self->pull();
    self->body_.reset();
    self->on_written();
  });
}

void HttpSession::on_written() { keep_alive_ ? read() : linger(); }

/// Closes so that the client can still read the response: what it goes on to send is taken for a while, or the kernel
/// would reset the connection.
void HttpSession::linger() {
  Code ignored;
  stream_.socket().shutdown(net::ip::tcp::socket::shutdown_send, ignored);
  stream_.expires_after(duration(linger_s));
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
  stream_.close();
  shared_->forget(shared_from_this());
}

bool HttpSession::client_gone() {
  char byte = 0;
  return ::recv(stream_.socket().native_handle(), &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

}  // namespace headframe
