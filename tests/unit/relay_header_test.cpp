// What a server that stands by says of a client: written, read, and nothing else taken for it.
#include "server/security/relay_header.hpp"

#include <gtest/gtest.h>

#include "common/security/secret.hpp"

namespace headframe {
namespace {

using boost::asio::ip::make_address;
using boost::asio::ip::tcp;

const tcp::endpoint client4(make_address("203.0.113.7"), 40000), server4(make_address("192.0.2.1"), 7447);
const tcp::endpoint client6(make_address("2001:db8::7"), 40000), server6(make_address("2001:db8::1"), 7447);
const std::string key = relay_key("token");

std::string v4() { return relay_header(client4, server4, key); }
std::string v6() { return relay_header(client6, server6, key); }

ErrorCode fault(const std::string& header) {
  const auto client = relayed_client(header, key);
  EXPECT_FALSE(client);
  return client ? ErrorCode::internal : client.error().code;
}

TEST(RelayHeader, GivesTheClientsAddress) {
  EXPECT_EQ(relayed_client(v4(), key).value(), client4.address());
  EXPECT_EQ(relayed_client(v6(), key).value(), client6.address());
}

/// Byte by byte as HAProxy's specification has it, and the field with the code of RFC 2104 at its end.
TEST(RelayHeader, IsThatOfTheProxyProtocol) {
  const std::string known = to_hex(v4());
  EXPECT_EQ(known.substr(0, known.size() - 64),
            "0d0a0d0a000d0a515549540a"  // signature
            "21"
            "11"
            "002f"  // version 2, PROXY; TCP over IPv4; 47 bytes
            "cb007107"
            "c0000201"  // from, to
            "9c40"
            "1d17"      // ports
            "e00020");  // a field of 32 bytes
  EXPECT_EQ(to_hex(v6()).substr(24, 8), "21210047");
  EXPECT_EQ(to_hex(hmac_sha256("Jefe", "what do ya want for nothing?")),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
}

TEST(RelayHeader, ItsPreambleTellsHowLongItIs) {
  for (const std::string& header : {v4(), v6()})
    EXPECT_EQ(relay_bytes_left(header.substr(0, relay_preamble_bytes)).value(), header.size() - relay_preamble_bytes);
  EXPECT_FALSE(relay_bytes_left(v4().substr(0, relay_preamble_bytes - 1)));
  EXPECT_FALSE(relay_bytes_left(v4().substr(0, relay_preamble_bytes + 1)));
  EXPECT_FALSE(relay_bytes_left(""));
}

TEST(RelayHeader, IsTakenWholeAndAloneOnly) {
  for (const std::string& header : {v4(), v6()}) {
    for (std::size_t bytes = 0; bytes < header.size(); ++bytes)
      EXPECT_EQ(fault(header.substr(0, bytes)), ErrorCode::bad_input) << bytes;
    EXPECT_EQ(fault(header + '\0'), ErrorCode::bad_input);
  }
}

TEST(RelayHeader, ChangedInAnyBitIsNotTaken) {
  for (const std::string& header : {v4(), v6()})
    for (std::size_t bit = 0; bit < header.size() * 8; ++bit) {
      std::string changed = header;
      changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << bit % 8));
      EXPECT_FALSE(relayed_client(changed, key)) << "bit " << bit;
    }
}

TEST(RelayHeader, OfAnotherVersionCommandOrFamilyIsNone) {
  const auto with = [](std::size_t at, char byte) {
    std::string header = v4();
    header[at] = byte;
    return header;
  };
  EXPECT_EQ(fault(with(12, 0x11)), ErrorCode::bad_input) << "version 1";
  EXPECT_EQ(fault(with(12, 0x20)), ErrorCode::bad_input) << "LOCAL";
  EXPECT_EQ(fault(with(13, 0x12)), ErrorCode::bad_input) << "UDP";
  EXPECT_EQ(fault(with(13, 0x21)), ErrorCode::bad_input) << "IPv6 with IPv4's length";
  EXPECT_EQ(fault(with(15, 46)), ErrorCode::bad_input);
  EXPECT_EQ(fault(with(15, 48)), ErrorCode::bad_input);
}

TEST(RelayHeader, OfAnotherKeyIsRefused) {
  for (const std::string& other : {relay_key("tokem"), relay_key(""), std::string()}) {
    const auto client = relayed_client(relay_header(client4, server4, other), key);
    ASSERT_FALSE(client);
    EXPECT_EQ(client.error().code, ErrorCode::refused);
  }
  EXPECT_FALSE(relayed_client(relay_header(client4, server4, ""), "")) << "no key: nobody is believed";
}

}  // namespace
}  // namespace headframe
