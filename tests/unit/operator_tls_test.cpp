// The operator's API over HTTPS: whom a client takes for the server, and what is answered in the clear.
#include <gtest/gtest.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <fstream>

#include "common/security/private_file.hpp"
#include "common/security/secret.hpp"
#include "common/security/tls.hpp"
#include "server/cli/http_client.hpp"
#include "server/cli/trust.hpp"
#include "server/security/server_identity.hpp"
#include "tests/support/operator_server.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

namespace net = boost::asio;

/// A private key and a certificate for 127.0.0.1 that vouches for itself, as PEM.
std::string authority_for_loopback() {
  EVP_PKEY* key = EVP_EC_gen("P-256");
  X509* made = X509_new();
  X509_set_version(made, X509_VERSION_3);
  ASN1_INTEGER_set(X509_get_serialNumber(made), 7);
  X509_gmtime_adj(X509_getm_notBefore(made), -86400);
  X509_gmtime_adj(X509_getm_notAfter(made), 86400);
  X509_NAME_add_entry_by_txt(X509_get_subject_name(made), "CN", MBSTRING_ASC,
                             reinterpret_cast<const unsigned char*>("mine"), -1, -1, 0);
  X509_set_issuer_name(made, X509_get_subject_name(made));
  X509_set_pubkey(made, key);
  X509_EXTENSION* name = X509V3_EXT_conf_nid(nullptr, nullptr, NID_subject_alt_name, "IP:127.0.0.1");
  X509_add_ext(made, name, -1);
  X509_sign(made, key, EVP_sha256());
  BIO* out = BIO_new(BIO_s_mem());
  PEM_write_bio_PKCS8PrivateKey(out, key, nullptr, nullptr, 0, nullptr, nullptr);
  PEM_write_bio_X509(out, made);
  const char* data = nullptr;
  const auto size = BIO_get_mem_data(out, &data);
  std::string pem(data, static_cast<std::size_t>(size));
  BIO_free(out);
  X509_EXTENSION_free(name);
  X509_free(made);
  EVP_PKEY_free(key);
  return pem;
}

OperatorLimits short_handshake() {
  OperatorLimits limits;
  limits.handshake_s = 2;  // long enough for a handshake on busy cores
  return limits;
}

struct OperatorTlsTest : testing::Test {
  Result<HttpResponse> ask(const WebTrust& trust, const std::string& token = "right") {
    auto endpoint = *parse_http_endpoint("https://" + server.where());
    endpoint.token = token;
    endpoint.trust = trust;
    return HttpClient(endpoint).get("/api/v1/status");
  }
  /// What comes back for these bytes, until the server ends the connection.
  std::string raw(const std::string& bytes) {
    net::io_context io;
    net::ip::tcp::socket socket(io);
    socket.connect({net::ip::address_v4::loopback(), server.api.port()});
    boost::system::error_code ended;
    net::write(socket, net::buffer(bytes), ended);
    std::string answer;
    net::read(socket, net::dynamic_buffer(answer), ended);
    return answer;
  }

  const TempDir folder;
  const std::string pem = authority_for_loopback();
  Result<net::ssl::context> tls = server_tls(pem);
  OperatorServer server{short_handshake(), {.token = "right", .tls = &*tls}};
};

TEST_F(OperatorTlsTest, ThePinnedServerIsAsked) {
  const auto answer = ask({.fingerprint = fingerprint_of(pem).value()});
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_EQ(answer->status, 200);
  EXPECT_EQ(ask({.fingerprint = fingerprint_of(pem).value()}, "wrong")->status, 401);
}

TEST_F(OperatorTlsTest, AnotherServerIsRefusedByNameOfItsFingerprint) {
  const std::string other(32, 'x');
  for (const WebTrust& trust :
       {WebTrust{.fingerprint = other}, WebTrust{}, WebTrust{.fingerprint = other, .fingerprint_only = false}}) {
    const auto answer = ask(trust);
    ASSERT_FALSE(answer);
    EXPECT_EQ(answer.error().code, ErrorCode::refused) << answer.error().message;
    EXPECT_NE(answer.error().message.find(to_hex(fingerprint_of(pem).value())), std::string::npos);
  }
}

TEST_F(OperatorTlsTest, WhoAnAuthorityVouchesForIsAskedUnderThatNameOnly) {
  const auto file = folder.path() / "ca.pem";
  std::ofstream(file) << pem.substr(pem.find("-----BEGIN CERT"));
  EXPECT_EQ(ask({.authorities = file})->status, 200);
  const WebTrust either{.fingerprint = std::string(32, 'x'), .authorities = file, .fingerprint_only = false};
  EXPECT_EQ(ask(either)->status, 200);
  auto endpoint = *parse_http_endpoint("https://localhost:" + std::to_string(server.api.port()));
  endpoint.trust.authorities = file;
  const auto otherwise = HttpClient(endpoint).get("/healthz");
  ASSERT_FALSE(otherwise);
  EXPECT_EQ(otherwise.error().code, ErrorCode::refused);
  EXPECT_EQ(ask({.authorities = folder.path() / "none"}).error().code, ErrorCode::not_found);
  std::ofstream(folder.path() / "junk") << "junk";
  EXPECT_EQ(ask({.authorities = folder.path() / "junk"}).error().code, ErrorCode::bad_input);
}

TEST_F(OperatorTlsTest, InTheClearThePageIsSentOnProbesAreAnsweredAndTheRestIsRefused) {
  const auto asked = [&](const std::string& what, const std::string& more = "") {
    return raw(what + " HTTP/1.1\r\nHost: mine:7448\r\n" + more + "\r\n");
  };
  const std::string page = asked("GET /");
  EXPECT_EQ(page.substr(9, 3), "307");
  EXPECT_NE(page.find("\r\nLocation: https://mine:7448/\r\n"), std::string::npos) << page;
  EXPECT_EQ(asked("GET /healthz", "Connection: close\r\n").substr(9, 3), "200");
  EXPECT_EQ(asked("GET /readyz", "Connection: close\r\n").substr(9, 3), "200");
  const std::string refused = asked("GET /api/v1/status", "Authorization: Bearer right\r\n");
  EXPECT_EQ(refused.substr(9, 3), "403");
  EXPECT_NE(refused.find("https://mine:7448"), std::string::npos) << refused;
  EXPECT_EQ(asked("POST /api/v1/merge", "Authorization: Bearer right\r\nContent-Length: 0\r\n").substr(9, 3), "403");
  EXPECT_EQ(server.station.merges, 0);
}

TEST_F(OperatorTlsTest, WhoShakesNoHandsIsNotWaitedFor) {
  EXPECT_EQ(raw(""), "") << "nothing at all";
  EXPECT_EQ(raw("\x16\x03\x01\x02"), "") << "the beginning of a handshake";
  EXPECT_EQ(raw("\x16\x03\x01" + std::string(1000, 'x')).substr(9, 3), "400") << "neither TLS nor HTTP";
  EXPECT_EQ(ask({.fingerprint = fingerprint_of(pem).value()})->status, 200);
}

TEST_F(OperatorTlsTest, ALongAnswerArrivesWhole) {
  auto endpoint = *parse_http_endpoint("https://" + server.where());
  endpoint.token = "right";
  endpoint.trust.fingerprint = fingerprint_of(pem).value();
  std::string taken;
  const auto answer =
      HttpClient(endpoint).get("/api/v1/export?component=1&format=ply&voxel=0", [&](std::string_view piece) {
        taken += piece;
        return Result<void>();
      });
  ASSERT_TRUE(answer) << answer.error().message;
  OperatorServer plain;
  EXPECT_EQ(taken,
            HttpClient(*parse_http_endpoint(plain.where())).get("/api/v1/export?component=1&format=ply&voxel=0")->body);
  EXPECT_GT(taken.size(), 100U);
}

TEST(HttpEndpoint, IsAskedOverTlsUnlessItIsOnTheLoopbackOrSaidOtherwise) {
  EXPECT_FALSE(parse_http_endpoint("127.0.0.1:7448")->tls);
  EXPECT_FALSE(parse_http_endpoint("localhost:7448")->tls);
  EXPECT_TRUE(parse_http_endpoint("10.0.0.7:7448")->tls);
  EXPECT_TRUE(parse_http_endpoint("mine.example:7448")->tls);
  EXPECT_FALSE(parse_http_endpoint("http://10.0.0.7:7448")->tls);
  EXPECT_TRUE(parse_http_endpoint("https://127.0.0.1:7448/")->tls);
  EXPECT_EQ(parse_http_endpoint("https://[::1]:7448/")->host, "::1");
  for (const char* bad : {"https://", "https://mine", "ftp://mine:7448", "https://mine:7448/page"})
    EXPECT_FALSE(parse_http_endpoint(bad)) << bad;
}

TEST(GivenIdentity, IsReadFromOneFileOrTwoAndRefusedWhenOthersCanReadTheKey) {
  const TempDir folder;
  const std::string pem = authority_for_loopback();
  const std::size_t begins = pem.find("-----BEGIN CERT");
  const auto both = folder.path() / "both.pem", key = folder.path() / "key.pem", certificate = folder.path() / "c.pem";
  ASSERT_TRUE(write_private_file(both, pem));
  ASSERT_TRUE(write_private_file(key, pem.substr(0, begins)));
  std::ofstream(certificate) << pem.substr(begins);
  EXPECT_EQ(given_identity(both, "")->fingerprint, fingerprint_of(pem).value());
  EXPECT_EQ(given_identity(certificate, key)->fingerprint, fingerprint_of(pem).value());
  EXPECT_EQ(given_identity(certificate, "").error().code, ErrorCode::refused) << "others can read it";
  EXPECT_EQ(given_identity(folder.path() / "none", key).error().code, ErrorCode::not_found);
  EXPECT_EQ(given_identity(certificate, folder.path() / "none").error().code, ErrorCode::not_found);
  ASSERT_TRUE(write_private_file(key, make_identity().value()));
  EXPECT_EQ(given_identity(certificate, key).error().code, ErrorCode::bad_input) << "of another certificate";
}

TEST(FindTrust, IsAFingerprintAnAuthorityOrWhatLiesBesideTheToken) {
  const TempDir folder;
  const std::string pem = make_identity().value(), digest = fingerprint_of(pem).value(), hex = to_hex(digest);
  EXPECT_EQ(find_trust(hex, "", "")->fingerprint, digest);
  std::string spelt;
  for (std::size_t at = 0; at < hex.size(); at += 2) {
    spelt += at == 0 ? "" : ":";
    for (const char digit : hex.substr(at, 2)) spelt += static_cast<char>(std::toupper(digit));
  }
  EXPECT_EQ(find_trust(spelt, "", "")->fingerprint, digest) << "as browsers spell it";
  EXPECT_TRUE(find_trust(hex, "", "")->fingerprint_only);
  EXPECT_EQ(find_trust(hex.substr(1), "", "").error().code, ErrorCode::invalid_argument);
  EXPECT_EQ(find_trust(hex, "ca.pem", "").error().code, ErrorCode::invalid_argument);
  EXPECT_EQ(find_trust("", "ca.pem", "")->authorities, "ca.pem");
  ASSERT_TRUE(write_private_file(folder.path() / "identity.pem", pem));
  const auto beside = find_trust("", "", (folder.path() / "operator.token").string());
  EXPECT_EQ(beside->fingerprint, digest);
  EXPECT_FALSE(beside->fingerprint_only);
  EXPECT_EQ(find_trust("", "", "/nowhere/operator.token")->fingerprint, "");
}

}  // namespace
}  // namespace headframe
