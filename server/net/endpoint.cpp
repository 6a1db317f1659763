#include "server/net/endpoint.hpp"

#include <boost/asio/ip/address.hpp>
#include <charconv>

namespace headframe {

Result<Endpoint> parse_endpoint(std::string_view text) {
  const auto bad = [&] {
    return failure(ErrorCode::invalid_argument,
                   std::string(text) + " is no HOST:PORT, such as 127.0.0.1:7447 or [::1]:7447");
  };
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return bad();
  std::string_view host = text.substr(0, colon);
  const std::string_view digits = text.substr(colon + 1);
  if (host.front() == '[' && host.back() == ']' && host.size() > 2)
    host = host.substr(1, host.size() - 2);
  else if (host.find_first_of(":[]") != std::string_view::npos)
    return bad();
  std::uint16_t port = 0;
  const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (digits.empty() || fault != std::errc() || end != digits.data() + digits.size()) return bad();
  return Endpoint{std::string(host), port};
}

bool is_loopback(const Endpoint& endpoint) {
  boost::system::error_code no_address;
  const auto address = boost::asio::ip::make_address(endpoint.host, no_address);
  return no_address ? endpoint.host == "localhost" : address.is_loopback();
}

std::string to_string(const Endpoint& endpoint) {
  const bool v6 = endpoint.host.find(':') != std::string::npos;
  std::string text(v6 ? 1 : 0, '[');
  text += endpoint.host;
  if (v6) text += ']';
  return text + ':' + std::to_string(endpoint.port);
}

}  // namespace headframe
