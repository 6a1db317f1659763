#include <ctime>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/endpoint.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/table.hpp"

namespace headframe {
namespace {

using Json = nlohmann::json;

std::string time_text(const Json& seconds) {
  if (!seconds.is_number()) return "-";
  const auto time = static_cast<std::time_t>(seconds.get<double>());
  std::tm local{};
  char text[32];
  ::localtime_r(&time, &local);
  return {text, std::strftime(text, sizeof text, "%Y-%m-%d %H:%M", &local)};
}

std::string rate_text(const Json& kib_s) {
  if (!kib_s.is_number() || kib_s == 0) return "what it can";
  return "at most " + std::to_string(kib_s.get<std::uint64_t>()) + " KiB/s";
}

std::string site_text(const Json& row) {
  const Json site = row.value("site", Json());
  return site.is_string() ? ", drives at " + printable(site.get<std::string>()) : "";
}

/// What a robot is to connect to. Who listens on every address does not know which of them that is.
std::string address_text(const Json& address) {
  const auto known = parse_endpoint(address.is_string() ? address.get<std::string>() : "");
  if (!known) return "HOST:PORT";
  return is_any_address(*known) ? "ADDRESS_OF_THE_SERVER:" + std::to_string(known->port) : printable(to_string(*known));
}

std::string robots_view(const Json& json) {
  std::ostringstream out;
  out << "server fingerprint " << printable(json.at("fingerprint").get<std::string>()) << "\n";
  for (const Json& row : json.at("robots"))
    out << printable(row.at("robot").get<std::string>()) << ": " << printable(row.at("state").get<std::string>())
        << ", enrolled " << time_text(row.at("enrolled_s")) << ", code open until "
        << time_text(row.at("code_expires_s")) << ", sends " << rate_text(row.at("rate_kib_s")) << site_text(row)
        << "\n";
  return out.str();
}

}  // namespace

Result<int> Commands::list_robots() { return printed(fetched("/api/v1/robots"), robots_view); }

Result<int> Commands::add_robot(const std::string& robot) {
  const auto body = posted("/api/v1/robots/add?robot=" + percent_encoded(robot), 201);
  if (!body) return tl::unexpected(body.error());
  const auto enrolment = Json::parse(*body).at("enrolment").get<std::string>();
  std::cout << (json_ ? *body : printable(enrolment) + "\n") << std::flush;
  if (json_) return exit_ok;
  const auto all = fetched("/api/v1/robots");
  const Json address = all ? Json::parse(*all).value("address", Json()) : Json();
  std::cerr << "headframe: good for one robot, once, for an hour: headframe-replay --server " << address_text(address)
            << " --robot " << printable(robot) << " --enrol " << printable(enrolment) << " SESSION_DIR\n";
  return exit_ok;
}

Result<int> Commands::revoke_robot(const std::string& robot) {
  return printed(posted("/api/v1/robots/revoke?robot=" + percent_encoded(robot), 200),
                 [&](const Json&) { return "robot " + printable(robot) + " is cut off\n"; });
}

Result<int> Commands::rate_robot(const std::string& robot, std::uint64_t kib_s) {
  const std::string target = "/api/v1/robots/rate?robot=" + percent_encoded(robot) + "&kib_s=" + std::to_string(kib_s);
  return printed(posted(target, 200),
                 [&](const Json&) { return "robot " + printable(robot) + " may send " + rate_text(kib_s) + "\n"; });
}

}  // namespace headframe
