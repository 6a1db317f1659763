// Operators with names: what each may do, for how long, and who is told to have done it.
#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "common/security/secret.hpp"
#include "server/operator/router.hpp"
#include "server/security/operator_guard.hpp"
#include "tests/support/operator_api_fixture.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

struct OperatorPeople : testing::Test {
  HttpResponse ask(const std::string& token, const std::string& method, const std::string& target) {
    auto endpoint = *parse_http_endpoint(server.where());
    endpoint.token = token;
    HttpClient client(endpoint);
    const auto response = method == "GET"      ? client.get(target)
                          : method == "DELETE" ? client.remove(target)
                                               : client.post(target);
    EXPECT_TRUE(response) << response.error().message;
    return response.value_or(HttpResponse{});
  }
  std::string added(const std::string& name, const std::string& role) {
    return Json::parse(ask("root", "POST", "/api/v1/operators/add?name=" + name + "&role=" + role).body)["token"];
  }

  TempDir folder;
  std::unique_ptr<OperatorRegistry> people = *OperatorRegistry::open(folder.path() / "operators.json");
  OperatorServer server{{}, {"root", nullptr, {}, {}, people.get()}};
};

TEST(OperatorRegistry, TokensAreKeptAsDigestsAndExpire) {
  const TempDir folder;
  const auto file = folder.path() / "operators.json";
  auto registry = *OperatorRegistry::open(file);
  const std::string token = *registry->add("anna", Role::view, 100, 1000);
  registry = *OperatorRegistry::open(file);
  ASSERT_TRUE(registry->find(token));
  EXPECT_EQ(registry->find(token)->role, Role::view);
  EXPECT_FALSE(registry->find(token + "0"));
  EXPECT_FALSE(registry->find(""));
  std::ifstream in(file);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  EXPECT_EQ(text.find(token), std::string::npos);
  OperatorGuard guard("root", {}, registry.get());
  const auto at = [&](double unix_s) { return guard.check("Bearer " + token, {}, {}, unix_s); };
  EXPECT_EQ(at(1099), OperatorGuard::Verdict::welcome);
  EXPECT_EQ(at(1100), OperatorGuard::Verdict::expired);
  EXPECT_TRUE(registry->stands(*registry->find(token), 1099));
  EXPECT_FALSE(registry->stands(*registry->find(token), 1100));
}

TEST(OperatorRegistry, AnotherTokenOfTheSameNameEndsTheFirstAndSoDoesRevoking) {
  const TempDir folder;
  auto registry = *OperatorRegistry::open(folder.path() / "operators.json");
  const std::string first = *registry->add("anna", Role::view, 100, 0);
  const OperatorIdentity was = *registry->find(first);
  const std::string second = *registry->add("anna", Role::operate, 100, 0);
  EXPECT_FALSE(registry->find(first));
  EXPECT_FALSE(registry->stands(was, 1));
  ASSERT_TRUE(registry->revoke("anna"));
  EXPECT_FALSE(registry->find(second));
  EXPECT_EQ(registry->revoke("anna").error().code, ErrorCode::not_found);
}

TEST(OperatorRegistry, HasItsLimitsAndRefusesADamagedFile) {
  const TempDir folder;
  const auto file = folder.path() / "operators.json";
  auto registry = *OperatorRegistry::open(file);
  for (const std::string name : {"", "a/b", ".."})
    EXPECT_EQ(registry->add(name, Role::view, 1, 0).error().code, ErrorCode::invalid_argument) << name;
  for (const double lifetime_s : {0.0, -1.0, OperatorRegistry::most_lifetime_s * 1.01})
    EXPECT_EQ(registry->add("anna", Role::view, lifetime_s, 0).error().code, ErrorCode::invalid_argument);
  for (std::size_t i = 0; i < OperatorRegistry::most_operators; ++i)
    ASSERT_TRUE(registry->add("op" + std::to_string(i), Role::view, 1, 0));
  EXPECT_EQ(registry->add("one-more", Role::view, 1, 0).error().code, ErrorCode::refused);
  EXPECT_TRUE(registry->add("op0", Role::operate, 1, 0));
  std::ofstream(file) << "{\"operators\":[{\"name\":1}]}";
  EXPECT_EQ(OperatorRegistry::open(file).error().code, ErrorCode::bad_input);
}

TEST_F(OperatorPeople, EachMayDoWhatTheRoleSaysAndNoMore) {
  const std::string view = added("vera", "view"), operate = added("otto", "operate"), all = added("ada", "administer");
  const auto status = [&](const std::string& token, const char* method, const char* target) {
    return ask(token, method, target).status;
  };
  for (const auto& token : {view, operate, all}) EXPECT_EQ(status(token, "GET", "/api/v1/status"), 200);
  EXPECT_EQ(status(view, "POST", "/api/v1/merge"), 403);
  EXPECT_EQ(server.station.merges, 0);
  EXPECT_EQ(status(operate, "POST", "/api/v1/merge"), 202);
  EXPECT_EQ(status(operate, "POST", "/api/v1/operators/add?name=eve"), 403);
  EXPECT_EQ(status(operate, "GET", "/api/v1/operators"), 403);
  EXPECT_EQ(status(operate, "DELETE", "/api/v1/sessions/1"), 403);
  EXPECT_EQ(status(operate, "GET", "/api/v1/backup"), 403) << "it holds the server's key and token";
  EXPECT_EQ(status(all, "GET", "/api/v1/operators"), 200);
  const Json me = Json::parse(ask(view, "GET", "/api/v1/me").body);
  EXPECT_EQ(me["name"], "vera");
  for (const std::string route : me["may"])
    EXPECT_TRUE(route.starts_with("GET ") || route.starts_with("POST /api/v1/sign-")) << route;
  EXPECT_EQ(Json::parse(ask("root", "GET", "/api/v1/me").body)["may"].size(), route_names().size());
  EXPECT_EQ(status(all, "POST", "/api/v1/operators/revoke?name=vera"), 200);
  EXPECT_EQ(status(view, "GET", "/api/v1/status"), 401);
}

TEST_F(OperatorPeople, TheLogSaysWhoDidWhat) {
  const std::string otto = added("otto", "operate");
  EXPECT_EQ(ask(otto, "POST", "/api/v1/merge").status, 202);
  EXPECT_EQ(ask(otto, "POST", "/api/v1/robots/add?robot=x").status, 403);
  const Json log = Json::parse(ask("root", "GET", "/api/v1/log").body)["entries"];
  std::vector<std::string> lines;
  for (const Json& entry : log)
    if (entry["kind"] == "operator") lines.push_back(entry["text"].get<std::string>() + " " + entry["by"].dump());
  EXPECT_EQ(lines,
            (std::vector<std::string>{"An operator lets otto operate. null", "otto asked for merges. \"otto\""}));
}

TEST(OperatorRoles, EveryRouteThatChangesSomethingAsksForMoreThanLooking) {
  for (const RouteName& route : route_names())
    EXPECT_TRUE(route.method == "GET" || route.path.starts_with("/api/v1/sign-") ||
                role_for(route.method, route.path) >= Role::operate)
        << route.path;
}

}  // namespace
}  // namespace headframe
