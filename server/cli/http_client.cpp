#include "server/cli/http_client.hpp"

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <chrono>
#include <limits>

#include "common/security/secret.hpp"
#include "common/security/tls.hpp"
#include "common/security/web_stream.hpp"

namespace headframe {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using boost::system::error_code;

constexpr std::size_t collected_bytes = 64 * 1024 * 1024;

/// Asio's timeouts hold for asynchronous calls only: each step is one, run to its end.
class Exchange {
 public:
  Exchange(const HttpEndpoint& endpoint, const HttpWatch& watch) : endpoint_(endpoint), watch_(watch) {
    parser_.body_limit(std::numeric_limits<std::uint64_t>::max());  // Beast 1.74 takes boost::none for 0
  }

  Result<void> connect(double timeout_s);
  Result<void> secure(double timeout_s);
  Result<void> send(std::string_view method, std::string_view target, std::string_view body, double timeout_s);
  Result<HttpResponse> receive(const HttpSink& sink, double timeout_s);

 private:
  template <class Start>
  error_code finish(double timeout_s, Start&& start) {
    error_code result;
    stream_.next_layer().expires_after(std::chrono::milliseconds(static_cast<std::int64_t>(timeout_s * 1000)));
    start([&result](error_code code, auto&&...) { result = code; });
    io_.restart();
    const auto began = std::chrono::steady_clock::now();
    while (io_.run_for(std::chrono::seconds(1)), !io_.stopped())
      if (watch_.waiting)
        watch_.waiting(std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
    return result;
  }
  tl::unexpected<Error> broken(error_code code) const;
  tl::unexpected<Error> untrusted(error_code code) const;

  const HttpEndpoint& endpoint_;
  const HttpWatch& watch_;
  net::io_context io_;
  std::unique_ptr<WebTls> tls_;  // outlives the stream
  WebStream stream_{io_};
  beast::flat_buffer buffer_;
  http::response_parser<http::buffer_body> parser_;
};

tl::unexpected<Error> Exchange::broken(error_code code) const {
  const bool silent = code == beast::error::timeout;
  return failure(
      ErrorCode::unavailable,
      silent ? "the server at " + to_string(endpoint_) + " does not answer; is it busy, or not headframe-server?"
             : "the server at " + to_string(endpoint_) + " broke off before its answer was complete (" +
                   code.message() + "); look at its log");
}

Result<void> Exchange::connect(double timeout_s) {
  error_code code;
  const auto found = net::ip::tcp::resolver(io_).resolve(endpoint_.host, std::to_string(endpoint_.port), code);
  if (code)
    return failure(ErrorCode::unavailable, "the host \"" + endpoint_.host + "\" is not known (" + code.message() + ")");
  code = finish(timeout_s, [&](auto done) { stream_.next_layer().async_connect(found, std::move(done)); });
  if (!code) return {};
  return failure(ErrorCode::unavailable, "no headframe-server answers at " + to_string(endpoint_) + " (" +
                                             code.message() + "); start it, or say where it is with --http HOST:PORT");
}

Result<void> Exchange::secure(double timeout_s) {
  if (!endpoint_.tls) return {};
  auto tls = WebTls::make(endpoint_.trust);
  if (!tls) return tl::unexpected(tls.error());
  tls_ = std::move(*tls);
  WebTls::ask_for(stream_.begin_tls(tls_->context()), endpoint_.host);
  const error_code code = finish(timeout_s, [&](auto done) {
    stream_.async_handshake(net::ssl::stream_base::client, net::const_buffer(), std::move(done));
  });
  if (code) return untrusted(code);
  return {};
}

tl::unexpected<Error> Exchange::untrusted(error_code code) const {
  const std::string who = "the server at " + to_string(endpoint_);
  if (tls_->refused().empty())
    return failure(ErrorCode::unavailable, who + " does not speak HTTPS (" + tls_trouble(code) +
                                               "); where nobody listens on the way, --http http://" +
                                               to_string(endpoint_) + " asks without");
  const std::string met = to_hex(tls_->refused());
  if (!endpoint_.trust.fingerprint.empty() && endpoint_.trust.fingerprint_only)
    return failure(ErrorCode::refused, who + " has another certificate than the one with the fingerprint that was " +
                                           "given: is it another server? Its fingerprint is " + met);
  return failure(ErrorCode::refused, who +
                                         " has a certificate that nobody known here vouches for. Its fingerprint is " +
                                         met + ": if that is what headframe-server printed at its start, give " +
                                         "--fingerprint " + met + "; or --ca FILE, the certificate of who vouches");
}

Result<void> Exchange::send(std::string_view method, std::string_view target, std::string_view body, double timeout_s) {
  http::request<http::string_body> request;
  request.body() = body;
  request.version(11);
  request.method_string({method.data(), method.size()});
  request.target({target.data(), target.size()});
  request.set(http::field::host, to_string(endpoint_));
  request.set(http::field::user_agent, "headframe");
  if (!endpoint_.token.empty()) request.set(http::field::authorization, "Bearer " + endpoint_.token);
  request.keep_alive(false);
  request.prepare_payload();
  const error_code code = finish(timeout_s, [&](auto done) { http::async_write(stream_, request, std::move(done)); });
  if (code) return broken(code);
  return {};
}

Result<HttpResponse> Exchange::receive(const HttpSink& sink, double timeout_s) {
  error_code code =
      finish(timeout_s, [&](auto done) { http::async_read_header(stream_, buffer_, parser_, std::move(done)); });
  if (code) return broken(code);
  HttpResponse response{static_cast<int>(parser_.get().result_int()), {}};
  const bool collect = !sink || response.status != 200;
  if (const auto length = parser_.content_length(); length && !collect && watch_.length) watch_.length(*length);
  std::array<char, 64 * 1024> piece;
  while (!parser_.is_done()) {
    auto& body = parser_.get().body();
    body.data = piece.data();
    body.size = piece.size();
    code = finish(timeout_s, [&](auto done) { http::async_read_some(stream_, buffer_, parser_, std::move(done)); });
    if (code && code != http::error::need_buffer) return broken(code);
    const std::string_view got(piece.data(), piece.size() - body.size);
    if (!collect) {
      if (auto taken = sink(got); !taken) return tl::unexpected(taken.error());
    } else if (response.body.size() + got.size() > collected_bytes) {
      return failure(ErrorCode::bad_input, "the answer of " + to_string(endpoint_) + " is longer than 64 MiB");
    } else {
      response.body += got;
    }
  }
  return response;
}

}  // namespace

Result<HttpEndpoint> parse_http_endpoint(std::string_view text) {
  constexpr std::string_view plain = "http://", secure = "https://";
  const bool is_plain = text.starts_with(plain), is_secure = text.starts_with(secure);
  if (is_plain || is_secure) text.remove_prefix(is_plain ? plain.size() : secure.size());
  if ((is_plain || is_secure) && text.ends_with('/')) text.remove_suffix(1);
  return parse_peer(text).map([&](Endpoint endpoint) {
    const bool tls = is_secure || (!is_plain && !is_loopback(endpoint));
    return HttpEndpoint{std::move(endpoint), {}, tls, {}};
  });
}

std::string percent_encoded(std::string_view text) {
  constexpr std::string_view digits = "0123456789ABCDEF";
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z') || (byte >= '0' && byte <= '9') ||
                       std::string_view("-._~").find(c) != std::string_view::npos;
    if (plain) {
      out += c;
    } else {
      out += '%';
      out += digits[byte >> 4];
      out += digits[byte & 15];
    }
  }
  return out;
}

Result<HttpResponse> HttpClient::ask(const Question& question, const HttpSink& sink, const HttpWatch& watch) {
  try {
    Exchange exchange(endpoint_, watch);
    if (auto connected = exchange.connect(timeouts_.connect_s); !connected) return tl::unexpected(connected.error());
    if (auto secured = exchange.secure(timeouts_.connect_s); !secured) return tl::unexpected(secured.error());
    if (auto sent = exchange.send(question.method, question.target, question.body, timeouts_.silence_s); !sent)
      return tl::unexpected(sent.error());
    return exchange.receive(sink, timeouts_.silence_s);
  } catch (const std::exception& exception) {  // of Asio or Beast: ends here
    return failure(ErrorCode::internal, std::string("HTTP: ") + exception.what());
  }
}

}  // namespace headframe
