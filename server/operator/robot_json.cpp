#include "server/operator/robot_json.hpp"

#include "server/operator/json_text.hpp"

namespace headframe {
namespace {

Json time_or_null(double seconds) { return seconds > 0 ? Json(seconds) : Json(); }

}  // namespace

std::string robots_json(const std::vector<RobotRow>& robots, const std::string& fingerprint, const std::string& address,
                        const std::map<std::string, std::string>& sites) {
  Json rows = Json::array();
  for (const RobotRow& row : robots) {
    const auto site = sites.find(row.robot);
    rows.push_back({{"robot", row.robot},
                    {"state", row.state},
                    {"enrolled_s", time_or_null(row.enrolled_s)},
                    {"code_expires_s", time_or_null(row.code_expires_s)},
                    {"site", site == sites.end() ? Json() : Json(site->second)},
                    {"rate_kib_s", row.rate_kib_s > 0 ? Json(row.rate_kib_s) : Json()}});
  }
  return text({{"fingerprint", fingerprint},
               {"address", address.empty() ? Json() : Json(address)},
               {"robots", std::move(rows)}});
}

std::string enrolment_json(const std::string& robot, const std::string& enrolment) {
  return text({{"robot", robot}, {"enrolment", enrolment}});
}

}  // namespace headframe
