#include <nlohmann/json.hpp>

#include "server/cli/commands.hpp"
#include "server/cli/table.hpp"

namespace headframe {
namespace {

using Json = nlohmann::json;

std::string site_name(const Json& site) { return site.is_string() ? printable(site.get<std::string>()) : "(no site)"; }

std::string sites_view(const Json& json) {
  std::string out;
  for (const Json& row : json.at("sites")) {
    const std::size_t sessions = row.at("sessions").size();
    out += site_name(row.at("site")) + ": " + std::to_string(sessions) + (sessions == 1 ? " session" : " sessions");
    std::string robots;
    for (const Json& robot : row.at("robots"))
      robots += (robots.empty() ? "; also what these begin: " : ", ") + printable(robot.get<std::string>());
    out += robots + "\n";
  }
  return out.empty() ? "no session yet, and no robot has a site\n" : out;
}

std::string of_site(const std::string& site) { return site.empty() ? "no site" : "the site " + printable(site); }

}  // namespace

Result<int> Commands::list_sites() { return printed(fetched("/api/v1/sites"), sites_view); }

Result<int> Commands::set_robot_site(const std::string& robot, const std::string& site) {
  const std::string target = "/api/v1/sites?robot=" + percent_encoded(robot) + "&site=" + percent_encoded(site);
  return printed(posted(target, 200), [&](const Json&) {
    return "sessions that " + printable(robot) + " begins from now on are of " + of_site(site) +
           "; those it began stay where they are: headframe site session takes one there\n";
  });
}

Result<int> Commands::set_session_site(const std::string& session, const std::string& site) {
  return session_named(session).and_then([&](const Json& row) {
    const std::string target = "/api/v1/sessions/" + row.at("id").dump() + "/site?site=" + percent_encoded(site);
    return printed(posted(target, 200), [&](const Json& now) {
      return printable(now.at("robot").get<std::string>() + "/" + now.at("session").get<std::string>()) + " is of " +
             of_site(site) + "; it is merged with those there alone\n";
    });
  });
}

}  // namespace headframe
