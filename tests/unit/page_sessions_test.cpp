// Who signed in with a token once is known by a cookie, which no other site can make use of.
#include "server/security/page_sessions.hpp"

#include "common/security/secret.hpp"
#include "tests/support/operator_api_fixture.hpp"
#include "tests/support/raw_client.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

using namespace std::chrono_literals;

TEST(PageSessions, EndWhenTheyAreSaidToUnusedForLongOrTooMany) {
  PageSessions sessions;
  PageSessions::Time now{};
  const std::string first = sessions.begin("Bearer a", now), second = sessions.begin("Bearer b", now + 1s);
  EXPECT_TRUE(from_hex(first, token_bytes));
  EXPECT_EQ(sessions.credentials(first, now + 11h), "Bearer a") << "used again";
  EXPECT_EQ(sessions.credentials(second, now + 12h + 1s), std::nullopt);
  EXPECT_EQ(sessions.credentials(first, now + 12h + 1s), "Bearer a");
  EXPECT_EQ(sessions.credentials(first.substr(1), now), std::nullopt);
  sessions.end(first);
  EXPECT_EQ(sessions.credentials(first, now), std::nullopt);
  const std::string oldest = sessions.begin("Bearer c", now), next = sessions.begin("Bearer d", now + 1s);
  for (std::size_t i = 2; i <= PageSessions::most; ++i) (void)sessions.begin("Bearer e", now + 2s);
  EXPECT_EQ(sessions.credentials(oldest, now + 3s), std::nullopt);
  EXPECT_EQ(sessions.credentials(next, now + 3s), "Bearer d");
}

struct PageCookie : testing::Test {
  /// The answer to a request with these fields beside Host, whole.
  std::string ask(const std::string& method, const std::string& target, const std::string& fields,
                  const std::string& connection = "close") const {
    RawClient client(server.api.port());
    client.send(method + " " + target + " HTTP/1.1\r\nHost: " + server.where() + "\r\nConnection: " + connection +
                "\r\n" + fields + "\r\n");
    return connection == "close" ? client.rest() : client.header();
  }
  std::string status(const std::string& method, const std::string& target, const std::string& fields) const {
    return status_of(ask(method, target, fields)).substr(9);
  }
  /// A Cookie field, as a browser that was answered so sends it from then on.
  static std::string cookie_of(const std::string& answer) {
    const std::string field = "Set-Cookie: ";
    const std::size_t at = answer.find(field);
    return at == std::string::npos ? "" : "Cookie: " + answer.substr(at + 12, answer.find(';', at) - at - 12) + "\r\n";
  }
  std::string signed_in(const std::string& token) const {
    return cookie_of(ask("POST", "/api/v1/sign-in", "Authorization: Bearer " + token + "\r\n"));
  }

  TempDir folder;
  std::unique_ptr<OperatorRegistry> people = *OperatorRegistry::open(folder.path() / "operators.json");
  OperatorServer server{{}, {"root", nullptr, {}, {}, people.get()}};
  const std::string own = "Origin: http://" + server.where() + "\r\n", foreign = "Origin: http://evil.example\r\n";
};

TEST_F(PageCookie, StandsForTheTokenAndIsOutOfReachOfScripts) {
  const std::string answer = ask("POST", "/api/v1/sign-in", "Authorization: Bearer root\r\n");
  EXPECT_EQ(status_of(answer), "HTTP/1.1 200");
  EXPECT_NE(answer.find("Set-Cookie: headframe-" + std::to_string(server.api.port()) + "="), std::string::npos);
  EXPECT_NE(answer.find("; Path=/; HttpOnly; SameSite=Strict\r\n"), std::string::npos) << answer;
  const std::string cookie = cookie_of(answer);
  EXPECT_EQ(cookie.find("root"), std::string::npos);
  EXPECT_EQ(status("GET", "/api/v1/status", cookie), "200");
  EXPECT_EQ(status("GET", "/api/v1/status", ""), "401");
  EXPECT_EQ(status("GET", "/api/v1/status", "Cookie: headframe=root\r\n"), "401");
  EXPECT_EQ(status("POST", "/api/v1/sign-in", "Authorization: Bearer wrong\r\n"), "401");
  const std::string out = ask("POST", "/api/v1/sign-out", cookie + own);
  EXPECT_NE(out.find("=; Max-Age=0"), std::string::npos) << out;
  EXPECT_EQ(status("GET", "/api/v1/status", cookie), "401");
}

TEST_F(PageCookie, ChangesAndListensForThePageOfThisServerAlone) {
  const std::string cookie = signed_in("root");
  EXPECT_EQ(status("POST", "/api/v1/merge", cookie + own), "202");
  EXPECT_EQ(status("POST", "/api/v1/merge", cookie + foreign), "401");
  EXPECT_EQ(status("POST", "/api/v1/merge", cookie), "401") << "a browser says where its page is from";
  EXPECT_EQ(server.station.merges, 1);
  const auto listens = [&](const std::string& fields) {
    const std::string key =
        "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
    return status_of(ask("GET", "/api/v1/events", key + cookie + fields, "Upgrade")).substr(9);
  };
  EXPECT_EQ(listens(own), "101");
  EXPECT_EQ(listens(foreign), "401");
  EXPECT_EQ(status("POST", "/api/v1/merge", "Authorization: Bearer root\r\n" + foreign), "202") << "by no cookie";
}

TEST_F(PageCookie, IsWorthNoMoreThanItsTokenIsNow) {
  const std::string token = *people->add("vera", Role::view, 100, 1e12);
  const std::string cookie = signed_in(token);
  EXPECT_NE(ask("GET", "/api/v1/me", cookie).find("\"vera\""), std::string::npos);
  EXPECT_EQ(status("POST", "/api/v1/merge", cookie + own), "403");
  ASSERT_TRUE(people->revoke("vera"));
  EXPECT_EQ(status("GET", "/api/v1/status", cookie), "401");
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(status("GET", "/api/v1/status", cookie), "401") << "it is gone, not wrong again";
}

}  // namespace
}  // namespace headframe
