#include <ctime>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "server/cli/commands.hpp"
#include "server/cli/table.hpp"

namespace headframe {
namespace {

std::string until_text(const nlohmann::json& seconds) {
  const auto time = static_cast<std::time_t>(seconds.get<double>());
  std::tm local{};
  char text[32];
  ::localtime_r(&time, &local);
  return {text, std::strftime(text, sizeof text, "%Y-%m-%d %H:%M", &local)};
}

std::string operators_view(const nlohmann::json& json) {
  std::ostringstream out;
  for (const nlohmann::json& row : json.at("operators"))
    out << printable(row.at("name").get<std::string>()) << ": may " << printable(row.at("role").get<std::string>())
        << ", until " << until_text(row.at("expires_s")) << "\n";
  return json.at("operators").empty() ? "nobody but who has operator.token\n" : out.str();
}

}  // namespace

Result<int> Commands::list_operators() { return printed(fetched("/api/v1/operators"), operators_view); }

Result<int> Commands::add_operator(const std::string& name, const std::string& role, double days) {
  std::ostringstream target;
  target << "/api/v1/operators/add?name=" << percent_encoded(name) << "&role=" << role << "&days=" << days;
  const auto body = posted(target.str(), 201);
  if (!body) return tl::unexpected(body.error());
  const auto json = nlohmann::json::parse(*body);
  std::cout << (json_ ? *body : printable(json.at("token").get<std::string>()) + "\n") << std::flush;
  if (json_) return exit_ok;
  std::cerr << "headframe: " << printable(name) << " may " << role << " with this token until "
            << until_text(json.at("expires_s"))
            << "; it is not shown again. The page asks for it; headframe takes it from $HEADFRAME_TOKEN\n";
  return exit_ok;
}

Result<int> Commands::revoke_operator(const std::string& name) {
  return printed(posted("/api/v1/operators/revoke?name=" + percent_encoded(name), 200),
                 [&](const nlohmann::json&) { return "the token of " + printable(name) + " ended\n"; });
}

}  // namespace headframe
