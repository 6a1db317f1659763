#include "server/security/relay_header.hpp"

#include <algorithm>

#include "common/security/secret.hpp"

namespace headframe {
namespace {

using boost::asio::ip::tcp;

constexpr std::string_view signature("\r\n\r\n\0\r\nQUIT\n", 12);
constexpr char proxied = 0x21;  // version 2, command PROXY
constexpr char tcp_v4 = 0x11, tcp_v6 = 0x21;
constexpr std::size_t v4_bytes = 4, v6_bytes = 16;
// A field of type, length and value, of a type that is left to applications.
constexpr std::string_view mac_field("\xe0\x00\x20", 3);
constexpr std::size_t mac_bytes = 32;

void append_number(std::string& out, std::size_t number) {
  out += static_cast<char>(number >> 8U & 0xffU);
  out += static_cast<char>(number & 0xffU);
}

void append_address(std::string& out, const boost::asio::ip::address& address) {
  const auto append = [&](const auto& bytes) { out.append(bytes.begin(), bytes.end()); };
  address.is_v4() ? append(address.to_v4().to_bytes()) : append(address.to_v6().to_bytes());
}

/// Two addresses, two ports, and the code.
std::size_t bytes_left(std::size_t address_bytes) {
  return 2 * address_bytes + 2 * sizeof(std::uint16_t) + mac_field.size() + mac_bytes;
}

template <class Address>
Address address_at(std::string_view bytes) {
  typename Address::bytes_type out{};
  std::copy_n(bytes.begin(), out.size(), out.begin());
  return Address(out);
}

tl::unexpected<Error> no_header() { return failure(ErrorCode::bad_input, "no header of a server that stands by"); }

}  // namespace

std::string relay_key(std::string_view operator_token) {
  return hmac_sha256(operator_token, "headframe: connections passed on by a server that stands by");
}

std::string relay_header(const tcp::endpoint& client, const tcp::endpoint& server, std::string_view key) {
  const bool v4 = client.address().is_v4();
  std::string header(signature);
  header += proxied;
  header += v4 ? tcp_v4 : tcp_v6;
  append_number(header, bytes_left(v4 ? v4_bytes : v6_bytes));
  append_address(header, client.address());
  append_address(header, server.address());
  append_number(header, client.port());
  append_number(header, server.port());
  header += mac_field;
  return header + hmac_sha256(key, header);
}

Result<std::size_t> relay_bytes_left(std::string_view preamble) {
  if (preamble.size() != relay_preamble_bytes || preamble.substr(0, signature.size()) != signature) return no_header();
  const std::string_view kind = preamble.substr(signature.size());
  for (const auto& [family, address_bytes] : {std::pair(tcp_v4, v4_bytes), std::pair(tcp_v6, v6_bytes)}) {
    std::string wanted{proxied, family};
    append_number(wanted, bytes_left(address_bytes));
    if (kind == wanted) return bytes_left(address_bytes);
  }
  return no_header();
}

Result<boost::asio::ip::address> relayed_client(std::string_view header, std::string_view key) {
  const auto left = relay_bytes_left(header.substr(0, relay_preamble_bytes));
  if (!left || header.size() != relay_preamble_bytes + *left) return no_header();
  const std::string_view covered = header.substr(0, header.size() - mac_bytes);
  if (!covered.ends_with(mac_field)) return no_header();
  if (key.empty() || !same_secret(header.substr(covered.size()), hmac_sha256(key, covered)))
    return failure(ErrorCode::refused, "a header that no server of this base station has made");
  const std::string_view addresses = header.substr(relay_preamble_bytes);
  if (*left == bytes_left(v4_bytes)) return address_at<boost::asio::ip::address_v4>(addresses);
  return address_at<boost::asio::ip::address_v6>(addresses);
}

}  // namespace headframe
