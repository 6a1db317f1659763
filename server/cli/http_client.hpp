#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "common/endpoint.hpp"
#include "common/security/web_tls.hpp"

namespace headframe {

struct HttpEndpoint : Endpoint {
  std::string token = {};  // sent with every request; empty: none
  bool tls = false;        // HTTPS
  WebTrust trust = {};     // whom it takes for the server then
};

/// "http://HOST:PORT", "https://HOST:PORT", or "HOST:PORT": without TLS on the loopback, with it anywhere else, where
/// others may listen. Without a token. Errors are those of parse_peer.
Result<HttpEndpoint> parse_http_endpoint(std::string_view text);

/// For a value in a query: "a b/c" -> "a%20b%2Fc".
std::string percent_encoded(std::string_view text);

struct HttpResponse {
  int status = 0;
  std::string body;  // empty when it went to a sink
};

struct HttpTimeouts {
  double connect_s = 5;
  double silence_s = 60;  // between two pieces of an answer; the first included
};

/// Takes a 200's body piece by piece; a failure ends the request and is what it returns.
using HttpSink = std::function<Result<void>(std::string_view)>;

/// For people who wait. Each may be empty.
struct HttpWatch {
  std::function<void(double waited_s)> waiting;     // once a second, while nothing comes
  std::function<void(std::uint64_t bytes)> length;  // of the body, when the server says it, before the first piece
};

/// HTTP/1.1, one connection for each request, blocking. An answer of any status is a result; unavailable: no server, no
/// answer in time, or an answer that broke off; refused: a server that is not the one it should be. Bodies without a
/// sink may have 64 MiB. Not thread safe.
class HttpClient {
 public:
  explicit HttpClient(HttpEndpoint endpoint, HttpTimeouts timeouts = {})
      : endpoint_(std::move(endpoint)), timeouts_(timeouts) {}

  Result<HttpResponse> get(std::string_view target, const HttpSink& sink = {}, const HttpWatch& watch = {}) {
    return ask({"GET", target, {}}, sink, watch);
  }
  Result<HttpResponse> post(std::string_view target, std::string_view body = {}, const HttpWatch& watch = {}) {
    return ask({"POST", target, body}, {}, watch);
  }
  Result<HttpResponse> remove(std::string_view target, const HttpWatch& watch = {}) {
    return ask({"DELETE", target, {}}, {}, watch);
  }
  const HttpEndpoint& endpoint() const { return endpoint_; }

 private:
  struct Question {
    std::string_view method, target, body;
  };
  Result<HttpResponse> ask(const Question& question, const HttpSink& sink, const HttpWatch& watch);

  HttpEndpoint endpoint_;
  HttpTimeouts timeouts_;
};

}  // namespace headframe
