#include "common/endpoint.hpp"

#include <arpa/inet.h>

#include <charconv>

namespace headframe {
namespace {

tl::unexpected<Error> no_endpoint(std::string_view text) {
  std::string message = "\"";
  message.append(text).append("\" is no HOST:PORT, such as 127.0.0.1:7447 or [::1]:7447");
  return failure(ErrorCode::invalid_argument, std::move(message));
}

}  // namespace

Result<Endpoint> parse_endpoint(std::string_view text) {
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return no_endpoint(text);
  std::string_view host = text.substr(0, colon);
  const std::string_view digits = text.substr(colon + 1);
  if (host.front() == '[' && host.back() == ']' && host.size() > 2)
    host = host.substr(1, host.size() - 2);
  else if (host.find_first_of(":[]") != std::string_view::npos)
    return no_endpoint(text);
  std::uint16_t port = 0;
  const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (digits.empty() || fault != std::errc() || end != digits.data() + digits.size()) return no_endpoint(text);
  return Endpoint{std::string(host), port};
}

Result<Endpoint> parse_peer(std::string_view text) {
  auto endpoint = parse_endpoint(text);
  if (endpoint && endpoint->port == 0) return no_endpoint(text);
  return endpoint;
}

Result<std::vector<Endpoint>> parse_peers(std::string_view text) {
  std::vector<Endpoint> peers;
  for (std::size_t begin = 0, end = 0; end != std::string_view::npos; begin = end + 1) {
    end = text.find(',', begin);
    auto peer = parse_peer(text.substr(begin, end - begin));
    if (!peer) return tl::unexpected(peer.error());
    peers.push_back(std::move(*peer));
  }
  return peers;
}

bool is_any_address(const Endpoint& endpoint) {
  in_addr v4{};
  in6_addr v6{};
  if (::inet_pton(AF_INET, endpoint.host.c_str(), &v4) == 1) return v4.s_addr == INADDR_ANY;
  return ::inet_pton(AF_INET6, endpoint.host.c_str(), &v6) == 1 && IN6_IS_ADDR_UNSPECIFIED(&v6);
}

bool is_loopback(const Endpoint& endpoint) {
  in_addr v4{};
  in6_addr v6{};
  if (::inet_pton(AF_INET, endpoint.host.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24 == IN_LOOPBACKNET;
  if (::inet_pton(AF_INET6, endpoint.host.c_str(), &v6) == 1) return IN6_IS_ADDR_LOOPBACK(&v6);
  return endpoint.host == "localhost";
}

std::string to_string(const Endpoint& endpoint) {
  const bool v6 = endpoint.host.find(':') != std::string::npos;
  std::string text(v6 ? 1 : 0, '[');
  text += endpoint.host;
  if (v6) text += ']';
  return text + ':' + std::to_string(endpoint.port);
}

}  // namespace headframe
