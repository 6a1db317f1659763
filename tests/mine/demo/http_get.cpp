#include "tests/mine/demo/http_get.hpp"

#include "server/cli/http_client.hpp"

namespace headframe::demo {

Result<nlohmann::json> http_get(const test::BaseStation& station, const std::string& target,
                                std::chrono::seconds timeout) {
  auto endpoint = parse_http_endpoint(station.http());
  const auto token = station.token();
  if (!endpoint) return tl::unexpected(endpoint.error());
  if (!token) return tl::unexpected(token.error());
  endpoint->token = *token;
  const auto response = HttpClient(*endpoint, {.silence_s = static_cast<double>(timeout.count())}).get(target);
  if (!response) return tl::unexpected(response.error());
  nlohmann::json json = nlohmann::json::parse(response->body, nullptr, false);
  if (response->status != 200 || json.is_discarded())
    return failure(ErrorCode::bad_input,
                   "http://" + station.http() + target + " answered " + std::to_string(response->status));
  return json;
}

}  // namespace headframe::demo
