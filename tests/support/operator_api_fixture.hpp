#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/cli/http_client.hpp"
#include "tests/support/operator_server.hpp"

namespace headframe {

using Json = nlohmann::json;

/// The operator API over a station of the test, and a client of it.
class OperatorApiTest : public testing::Test {
 protected:
  HttpResponse get(const std::string& target) { return taken(client.get(target)); }
  HttpResponse post(const std::string& target) { return taken(client.post(target)); }
  static HttpResponse taken(Result<HttpResponse> response) {
    EXPECT_TRUE(response) << response.error().message;
    return response.value_or(HttpResponse{});
  }
  void expect_error(const HttpResponse& response, int status, const std::string& code, const std::string& says) {
    EXPECT_EQ(response.status, status);
    const Json json = Json::parse(response.body);
    EXPECT_EQ(json["error"]["code"], code);
    EXPECT_NE(json["error"]["message"].get<std::string>().find(says), std::string::npos) << response.body;
  }

  OperatorServer server;
  HttpClient client{*parse_http_endpoint(server.where())};
};

}  // namespace headframe
