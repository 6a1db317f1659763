// Requests of an operator, from the bytes to what would be answered.
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>

#include "server/operator/http_rules.hpp"
#include "server/operator/router.hpp"
#include "server/security/relay_header.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/support/fake_station.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace headframe;
  namespace http = boost::beast::http;
  static FakeStation station;
  static PointTiles tiles(station);
  static const OperatorLimits limits;
  auto bytes = fuzz::text(data, size);
  std::string method = "GET", target(bytes), body;
  if (fuzz::take_byte(bytes) % 2 == 0) {
    http::request_parser<http::string_body> parser;
    parser.header_limit(static_cast<std::uint32_t>(limits.header_bytes));
    parser.body_limit(limits.body_bytes);
    boost::system::error_code code;
    while (!bytes.empty() && !code && !parser.is_done()) {
      const auto read = parser.put(boost::asio::buffer(bytes.data(), bytes.size()), code);
      if (read == 0) break;
      bytes.remove_prefix(read);
    }
    if (!parser.is_header_done()) return 0;
    method = std::string(parser.get().method_string());
    target = std::string(parser.get().target());
    body = parser.get().body();
  } else {
    method = fuzz::take_byte(bytes) % 2 == 0 ? "GET" : "POST";
    target = bytes.substr(0, bytes.find('\n'));
    if (target.size() < bytes.size()) body = bytes.substr(target.size() + 1);
  }
  (void)header_fault(target);
  fuzz::require(!relayed_client(fuzz::text(data, size), relay_key("a token that nobody knows")));
  const std::string_view cookie = cookie_value(target, page_cookie_name(body));
  fuzz::require(cookie.empty() || target.find(cookie) != std::string::npos);
  (void)same_origin(target, body);
  (void)own_host(target, body);
  (void)is_public(target);
  auto reply = route({method, target, body}, station, tiles, limits, 1.5);
  if (const auto* ready = std::get_if<Ready>(&reply)) fuzz::require(ready->status >= 200 && ready->status < 600);
  return 0;
}
