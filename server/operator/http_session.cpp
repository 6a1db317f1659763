#include "server/operator/http_session.hpp"

#include <boost/asio/bind_executor.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core/detect_ssl.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include "server/security/relay_header.hpp"
#include "server/security/relayed_peer.hpp"

namespace headframe {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;

std::string_view text(beast::string_view view) { return {view.data(), view.size()}; }

/// A page cannot set headers of a WebSocket, so it offers the subprotocols "headframe" and the token instead.
template <class Request>
std::string credentials_of(const Request& request) {
  const std::string_view offered = text(request[http::field::sec_websocket_protocol]);
  constexpr std::string_view prefix = "headframe, ";
  if (offered.substr(0, prefix.size()) == prefix) return "Bearer " + std::string(offered.substr(prefix.size()));
  return std::string(text(request[http::field::authorization]));
}

}  // namespace

HttpSession::HttpSession(net::ip::tcp::socket socket, std::shared_ptr<HttpShared> shared, bool turn_away)
    : stream_(std::move(socket)),
      look_(stream_.get_executor()),
      shared_(std::move(shared)),
      turn_away_(turn_away),
      buffer_(shared_->limits.header_bytes + 8192) {
  Code gone;
  from_ = tcp().socket().remote_endpoint(gone).address();
}

void HttpSession::start() {
  net::post(stream_.get_executor(), [self = shared_from_this()] { self->meet(); });
}

/// Looks at the first byte without reading it, to distinguish a standby server that relays an operator from an
/// operator.
void HttpSession::meet() {
  const OperatorLimits& limits = shared_->limits;
  const double patience_s = turn_away_ ? linger_s : shared_->tls != nullptr ? limits.handshake_s : limits.idle_s;
  look_.expires_after(std::chrono::milliseconds(std::llround(patience_s * 1000)));
  look_.async_wait([self = shared_from_this()](Code ended) {
    if (!ended) self->finish();
  });
  async_first_byte(tcp().socket(), [self = shared_from_this()](std::optional<unsigned char> first) {
    self->look_.cancel();
    if (!first) return self->finish();
    *first == relay_first_byte ? self->meet_relay() : self->begin();
  });
}

void HttpSession::meet_relay() {
  async_read_relay_header(tcp().socket(), shared_->relay_key,
                          [self = shared_from_this()](const Result<net::ip::address>& client) {
                            if (!client) return self->finish();
                            self->from_ = *client;
                            self->begin();
                          });
}

void HttpSession::begin() { shared_->tls == nullptr ? read() : detect_tls(); }

/// Uses the timer's executor, which is the stream's, because the stream itself may just be moving to the event feed.
void HttpSession::close() {
  net::post(look_.get_executor(), [self = shared_from_this()] { self->finish(); });
}

/// Performs a TLS handshake if the client begins one. Requests without TLS are answered by in_the_clear().
void HttpSession::detect_tls() {
  allow(turn_away_ ? linger_s : shared_->limits.handshake_s);
  beast::async_detect_ssl(stream_, buffer_, [self = shared_from_this()](Code code, bool tls) {
    if (code) return self->finish();
    if (!tls) return self->read();
    self->stream_.begin_tls(*self->shared_->tls);
    self->stream_.async_handshake(net::ssl::stream_base::server, self->buffer_.data(),
                                  [self](Code fault, std::size_t used_bytes) {
                                    self->buffer_.consume(used_bytes);
                                    fault ? self->finish() : self->read();
                                  });
  });
}

void HttpSession::read() {
  parser_.emplace();
  parser_->header_limit(static_cast<std::uint32_t>(shared_->limits.header_bytes));
  parser_->body_limit(shared_->limits.body_bytes);
  allow(turn_away_ ? linger_s : shared_->limits.idle_s);
  header_.clear();
  shared_->note(shared_from_this(), true, false);
  read_header();
}

/// Reads piece by piece and keeps the header as received, for two reasons: Beast 1.74 applies its header limit to each
/// field separately, so a header could be endless; and it accepts headers that header_fault() refuses.
void HttpSession::read_header() {
  parser_->eager(false);
  Code code;
  const std::size_t parsed_bytes = parser_->put(buffer_.data(), code);
  header_.append(static_cast<const char*>(buffer_.data().data()), parsed_bytes);
  buffer_.consume(parsed_bytes);
  if (code == http::error::need_more) code = {};
  const bool done = parser_->is_header_done();
  if (!code && header_.size() + (done ? 0 : buffer_.size()) > shared_->limits.header_bytes)
    code = http::error::header_limit;
  if (code) return on_read(code);
  if (done) return read_body();
  stream_.async_read_some(buffer_.prepare(4096), [self = shared_from_this()](Code read_code, std::size_t bytes) {
    self->buffer_.commit(bytes);
    if (!read_code) return self->read_header();
    const bool begun = !self->header_.empty() || self->buffer_.size() > 0;
    if (read_code == net::error::eof) read_code = begun ? http::error::partial_message : http::error::end_of_stream;
    self->on_read(read_code);
  });
}

void HttpSession::read_body() {
  if (const auto fault = header_fault(header_)) {
    tcp().expires_never();
    keep_alive_ = false;
    return send(error_reply({ErrorCode::bad_input, "this is not a request as HTTP/1.1 asks for: " + *fault}));
  }
  http::async_read(stream_, buffer_, *parser_,
                   [self = shared_from_this()](Code code, std::size_t) { self->on_read(code); });
}

void HttpSession::on_read(Code code) {
  tcp().expires_never();
  if (code) return refuse(code);
  const auto& request = parser_->get();
  keep_alive_ = request.keep_alive();
  if (turn_away_) {
    keep_alive_ = false;
    return send(error_reply({ErrorCode::unavailable, "too many connections; close some or try again later"}));
  }
  auto refusal = turned_down();
  shared_->note(shared_from_this(), false, has_token_);
  if (refusal) return send(std::move(*refusal));
  const std::chrono::duration<double> uptime = std::chrono::steady_clock::now() - shared_->started;
  try {
    perform(route({text(request.method_string()), text(request.target()), request.body(), who_}, shared_->station,
                  shared_->tiles, shared_->limits, uptime.count(), shared_->robots, shared_->records));
  } catch (const std::exception& exception) {  // thrown by a library: only this request fails
    send(error_reply({ErrorCode::internal, exception.what()}));
  }
}

/// Counts the request. Returns a refusal if its address sends too many.
std::optional<Ready> HttpSession::too_many(AttemptLimiter& requests, AttemptLimiter::Time now) const {
  if (requests.allowed(from_, now)) {
    requests.failed(from_, now);  // counts this request
    return std::nullopt;
  }
  std::ostringstream message;
  message << "too many requests from this address: " << shared_->limits.requests.failures << " at once, then "
          << shared_->limits.requests.forgiven_per_s << " a second; ask less often";
  return error_reply(429, {ErrorCode::refused, message.str()});
}

/// If TLS is required, the answer to a request without it. Public targets are redirected to HTTPS. Health probes are
/// allowed, because they neither reveal nor require a secret.
std::optional<Ready> HttpSession::in_the_clear() const {
  if (shared_->tls == nullptr || stream_.is_tls()) return std::nullopt;
  const auto& request = parser_->get();
  const std::string_view target = text(request.target()), host = text(request[http::field::host]);
  if (target == "/healthz" || target == "/readyz") return std::nullopt;
  const std::string there = "https://" + std::string(host);
  Ready answer = error_reply(
      {ErrorCode::refused, "this server speaks HTTPS: " + there + "; what was sent just now, others may have read"});
  if (host.empty() || !is_public(target)) return answer;
  answer.status = 307;  // temporary: TLS may be switched off again
  answer.location = there + std::string(target);
  return answer;
}

/// If no token is required, refuses requests that a foreign page may have made a browser on this network send.
std::optional<Ready> HttpSession::foreign() const {
  if (shared_->asks_token) return std::nullopt;
  const auto& request = parser_->get();
  const std::string_view host = text(request[http::field::host]);
  if (!own_host(host, shared_->served_under()))
    return error_reply({ErrorCode::refused, "this server goes by its address, not by the name in Host"});
  if (!same_origin(text(request[http::field::origin]), host, stream_.is_tls()))
    return error_reply({ErrorCode::refused, "a page of another origin may not ask"});
  return std::nullopt;
}

/// The credentials with which this page signed in. Empty: it did not, or a foreign page may have made the browser send
/// the cookie.
std::string HttpSession::credentials_of_page(std::chrono::steady_clock::time_point now) const {
  const auto& request = parser_->get();
  const std::string_view host = text(request[http::field::host]), origin = text(request[http::field::origin]);
  const bool looks = request.method() == http::verb::get && !beast::websocket::is_upgrade(request);
  if (!looks && (origin.empty() || !same_origin(origin, host, stream_.is_tls()))) return "";
  const std::string_view secret = cookie_value(text(request[http::field::cookie]), page_cookie_name(host));
  return secret.empty() ? "" : shared_->pages.credentials(secret, now).value_or("");
}

/// The Set-Cookie value that begins or ends a page session. Scripts cannot read the cookie, and pages of other sites
/// cannot make the browser send it.
std::string HttpSession::page_cookie(Ready::Page page) const {
  const auto& request = parser_->get();
  const std::string name = page_cookie_name(text(request[http::field::host]));
  const std::string kept = std::string("; Path=/; HttpOnly; SameSite=Strict") + (stream_.is_tls() ? "; Secure" : "");
  if (page == Ready::Page::begins)
    return name + "=" + shared_->pages.begin(credentials_, std::chrono::steady_clock::now()) + kept;
  shared_->pages.end(cookie_value(text(request[http::field::cookie]), name));
  return name + "=; Max-Age=0" + kept;
}

/// The refusal of a request that lacks a valid token or exceeds a limit; nullopt: it is accepted.
std::optional<Ready> HttpSession::turned_down() {
  using Verdict = OperatorGuard::Verdict;
  const auto& request = parser_->get();
  const auto now = std::chrono::steady_clock::now();
  if (auto refusal = in_the_clear()) {
    keep_alive_ = false;
    return refusal;
  }
  if (is_public(text(request.target()))) return too_many(shared_->strangers, now);
  if (auto refusal = foreign()) return refusal;
  const std::chrono::duration<double> unix_time = std::chrono::system_clock::now().time_since_epoch();
  credentials_ = credentials_of(request);
  const bool by_cookie = credentials_.empty();
  if (by_cookie) credentials_ = credentials_of_page(now);
  const auto verdict = shared_->guard.check(credentials_, from_, now, unix_time.count(), &who_);
  if (by_cookie && verdict != Verdict::welcome && !credentials_.empty()) (void)page_cookie(Ready::Page::ends);
  has_token_ = verdict == Verdict::welcome && shared_->asks_token;
  if (verdict == Verdict::welcome) return too_many(shared_->operators, now);
  if (verdict == Verdict::limited) {
    keep_alive_ = false;
    return error_reply(429, {ErrorCode::refused, "too many wrong tokens from this address; wait a minute"});
  }
  Ready refusal = error_reply(
      401, {ErrorCode::refused,
            verdict == Verdict::expired ? "this token has expired; ask who administers the server for another"
            : verdict == Verdict::missing
                ? "the operator's token is missing; it is in operator.token in the server's data directory: headframe "
                  "--token-file DIR/operator.token"
                : "this is not the operator's token; it is in operator.token in the server's data directory: headframe "
                  "--token-file DIR/operator.token"});
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

/// Hands the connection over to the event feed.
void HttpSession::upgrade() {
  const auto& request = parser_->get();
  if (!beast::websocket::is_upgrade(request))
    return send(error_reply(426, {ErrorCode::invalid_argument, "events are told over WebSocket; ask for an upgrade"}));
  if (!same_origin(text(request[http::field::origin]), text(request[http::field::host]), stream_.is_tls()))
    return send(error_reply({ErrorCode::refused, "a page of another origin may not listen"}));
  if (!shared_->events->take_place())
    return send(error_reply({ErrorCode::unavailable, "too many listen already; close some pages"}));
  handed_over_ = true;
  shared_->events->serve(std::move(stream_), parser_->release(), who_);
  shared_->forget(shared_from_this());
}

}  // namespace headframe
