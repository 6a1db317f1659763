// Who may use the operator's API: over real sockets, and the guard alone with a manual clock.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "common/security/secret.hpp"
#include "server/cli/http_client.hpp"
#include "server/security/operator_guard.hpp"
#include "tests/support/operator_server.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

using namespace std::chrono_literals;
using Verdict = OperatorGuard::Verdict;

TEST(OperatorToken, IsMadeOnceAndKept) {
  const TempDir dir;
  const auto token = operator_token(dir.path());
  ASSERT_TRUE(token) << token.error().message;
  EXPECT_TRUE(from_hex(*token, token_bytes));
  EXPECT_EQ(operator_token(dir.path()).value(), *token);
  std::ofstream(dir.path() / "operator.token") << "secret";
  const auto damaged = operator_token(dir.path());
  ASSERT_FALSE(damaged);
  EXPECT_EQ(damaged.error().message.find("secret"), std::string::npos) << damaged.error().message;
}

struct Guard : testing::Test {
  Verdict check(const std::string& authorization) { return guard.check(authorization, from, now); }
  const boost::asio::ip::address from = boost::asio::ip::make_address("10.0.0.1");
  AttemptLimiter::Time now{};
  OperatorGuard guard{"right", {.failures = 3, .forgiven_per_s = 1, .addresses = 10}};
};

TEST_F(Guard, OnlyTheWholeTokenInItsSchemeIsWelcome) {
  EXPECT_EQ(check("Bearer right"), Verdict::welcome);
  EXPECT_EQ(check(""), Verdict::missing);
  for (const std::string wrong : {"Bearer righ", "right", "Bearer righte", "bearer right", "Bearer", "Bearer "}) {
    EXPECT_EQ(check(wrong), Verdict::wrong) << wrong;
    now += 10s;
  }
}

TEST_F(Guard, WrongOnesAreLimitedAndTheRightOneIsNot) {
  for (int i = 0; i < 3; ++i) EXPECT_EQ(check("Bearer wrong"), Verdict::wrong);
  EXPECT_EQ(check("Bearer wrong"), Verdict::limited);
  EXPECT_EQ(check("Bearer right"), Verdict::welcome);
  now += 999ms;
  EXPECT_EQ(check("Bearer wrong"), Verdict::limited);
  now += 1001ms;
  EXPECT_EQ(check("Bearer wrong"), Verdict::wrong);
}

TEST_F(Guard, WhoShowsNothingHasTriedNothing) {
  for (int i = 0; i < 100; ++i) EXPECT_EQ(check(""), Verdict::missing);
  EXPECT_EQ(check("Bearer wrong"), Verdict::wrong);
}

TEST(OperatorApiToken, EveryRequestButTheHealthCheckNeedsIt) {
  OperatorServer server({}, {"right", nullptr});
  const auto ask = [&](const std::string& token, const std::string& target, bool post = false) {
    auto endpoint = *parse_http_endpoint(server.where());
    endpoint.token = token;
    const auto response = post ? HttpClient(endpoint).post(target) : HttpClient(endpoint).get(target);
    EXPECT_TRUE(response) << response.error().message;
    return response.value_or(HttpResponse{});
  };
  EXPECT_EQ(ask("", "/healthz").status, 200);
  EXPECT_EQ(ask("right", "/api/v1/status").status, 200);
  for (const std::string target :
       {"/api/v1/status", "/api/v1/sessions", "/api/v1/atlas", "/api/v1/export?component=1",
        "/api/v1/trajectory?robot=alpha&session=run/1", "/nowhere", "/healthz/../api", "//healthz"}) {
    const auto refused = ask("", target);
    EXPECT_EQ(refused.status, 401) << target;
    EXPECT_NE(refused.body.find("operator.token"), std::string::npos) << refused.body;
  }
  EXPECT_EQ(ask("", "/api/v1/merge", true).status, 401);
  EXPECT_EQ(server.station.merges, 0);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(ask("wrong", "/api/v1/status").status, 401);
  EXPECT_EQ(ask("wrong", "/api/v1/status").status, 429);
  EXPECT_EQ(ask("right", "/api/v1/merge", true).status, 202);
}

}  // namespace
}  // namespace headframe
