// Our TLS over real sockets: who gets through the handshake, and that bytes arrive.
#include "common/security/tls.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>

#include "common/security/link_stream.hpp"

namespace headframe {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using Code = boost::system::error_code;
using Side = asio::ssl::stream_base;

struct Tls : testing::Test {
  /// Connects both ends and shakes hands; true when both are content.
  bool handshake(asio::ssl::context& client_context) {
    tcp::acceptor acceptor(io, {asio::ip::address_v4::loopback(), 0});
    client.emplace(tcp::socket(io));
    client->socket().connect(acceptor.local_endpoint());
    server.emplace(acceptor.accept());
    client->async_handshake(client_context, Side::client, [this](Code code) {
      client_code = code;
      if (code) client->socket().close();
    });
    server->async_handshake(*server_context, Side::server, [this](Code code) {
      server_code = code;
      if (code) server->socket().close();
    });
    io.restart();
    io.run();
    return !client_code && !server_code;
  }

  asio::io_context io;
  const std::string pem = make_identity().value();
  Result<asio::ssl::context> server_context = server_tls(pem);
  std::optional<LinkStream> client, server;
  Code client_code, server_code;
};

TEST_F(Tls, ThePinnedServerIsTrustedAndBytesArrive) {
  PinnedTls pinned(fingerprint_of(pem).value());
  ASSERT_TRUE(handshake(pinned.context())) << client_code.message() << server_code.message();
  EXPECT_EQ(pinned.other(), "");
  const std::string sent(100'000, 'x');
  std::string received(sent.size(), '\0');
  int done = 0;
  asio::async_write(*client, asio::buffer(sent), [&](Code code, std::size_t) { done += code ? 0 : 1; });
  asio::async_read(*server, asio::buffer(received), [&](Code code, std::size_t) { done += code ? 0 : 1; });
  io.restart();
  io.run();
  EXPECT_EQ(done, 2);
  EXPECT_EQ(received, sent);
}

TEST_F(Tls, AnotherServerIsNotTrustedAndIsNamed) {
  PinnedTls pinned(fingerprint_of(make_identity().value()).value());
  EXPECT_FALSE(handshake(pinned.context()));
  EXPECT_TRUE(client_code);
  EXPECT_EQ(pinned.other(), fingerprint_of(pem).value());
}

TEST_F(Tls, AnOlderTlsIsRefusedByBothSides) {
  asio::ssl::context old(asio::ssl::context::tls_client);
  SSL_CTX_set_max_proto_version(old.native_handle(), TLS1_2_VERSION);
  EXPECT_FALSE(handshake(old));
  EXPECT_TRUE(server_code);

  SSL_CTX_set_min_proto_version(server_context->native_handle(), TLS1_2_VERSION);
  SSL_CTX_set_max_proto_version(server_context->native_handle(), TLS1_2_VERSION);
  PinnedTls pinned(fingerprint_of(pem).value());
  EXPECT_FALSE(handshake(pinned.context()));
  EXPECT_TRUE(client_code);
}

TEST(Identity, HasAKeyThatFitsAndIsNeverTheSame) {
  const std::string one = make_identity().value(), two = make_identity().value();
  EXPECT_NE(fingerprint_of(one).value(), fingerprint_of(two).value());
  const std::string begin = "-----BEGIN CERTIFICATE";
  const std::string mixed = one.substr(0, one.find(begin)) + two.substr(two.find(begin));
  for (const std::string& bad : {std::string(), mixed, one.substr(0, one.find(begin)), one.substr(one.find(begin))})
    EXPECT_FALSE(server_tls(bad));
  EXPECT_FALSE(fingerprint_of("nonsense"));
}

}  // namespace
}  // namespace headframe
