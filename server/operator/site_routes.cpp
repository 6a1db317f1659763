// Mines that share one database: sessions of two sites are never merged.
#include <map>

#include "server/operator/json_text.hpp"
#include "server/operator/routes.hpp"

namespace headframe::routes {
namespace {

struct Site {
  Json robots = Json::array();  // whose next sessions belong to this site
  Json sessions = Json::array();
};

std::string given_site(const Query& query) {
  const auto site = query.find("site");
  return site == query.end() ? std::string() : site->second;
}

}  // namespace

Result<Reply> sites(const Query&, const Context& context) {
  std::map<std::string, Site> all;
  for (const auto& [robot, site] : context.station.robot_sites()) all[site].robots.push_back(robot);
  for (const SessionRow& row : context.station.sessions()) all[row.site].sessions.push_back(row.id);
  Json rows = Json::array();
  for (auto& [site, of] : all)
    rows.push_back({{"site", site.empty() ? Json() : Json(site)},
                    {"robots", std::move(of.robots)},
                    {"sessions", std::move(of.sessions)}});
  return json(text({{"sites", std::move(rows)}}));
}

Result<Reply> set_robot_site(const Query& query, const Context& context) {
  const auto robot = required(query, "robot");
  if (!robot) return tl::unexpected(robot.error());
  return Later{[&station = context.station, robot = *robot, site = given_site(query)](const auto& answer) {
    station.set_robot_site(robot, site, [robot, site, answer](const Result<void>& done) {
      if (!done) return answer(error_reply(done.error()));
      answer(json(text({{"robot", robot}, {"site", site.empty() ? Json() : Json(site)}})));
    });
  }};
}

}  // namespace headframe::routes
