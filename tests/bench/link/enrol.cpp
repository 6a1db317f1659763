#include "tests/bench/link/enrol.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

#include "server/cli/http_client.hpp"

namespace headframe::bench {

Result<std::string> enrolment(const std::string& http, const std::filesystem::path& data, const std::string& robot) {
  auto endpoint = parse_http_endpoint(http);
  if (!endpoint) return tl::unexpected(endpoint.error());
  std::ifstream token(data / "operator.token");
  std::getline(token, endpoint->token);
  const auto response = HttpClient(*endpoint).post("/api/v1/robots/add?robot=" + percent_encoded(robot));
  if (!response) return tl::unexpected(response.error());
  const auto json = nlohmann::json::parse(response->body, nullptr, false);
  if (response->status != 201 || !json.contains("enrolment"))
    return failure(ErrorCode::unavailable, "robot " + robot + " can not enrol: " + response->body);
  return json["enrolment"].get<std::string>();
}

}  // namespace headframe::bench
