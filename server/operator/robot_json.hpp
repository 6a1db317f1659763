#pragma once
// The JSON of robots and enrolments. All functions are pure.

#include <map>

#include "server/station/robot_admin.hpp"

namespace headframe {

/// sites: by robot, only of robots that have one.
std::string robots_json(const std::vector<RobotRow>& robots, const std::string& fingerprint, const std::string& address,
                        const std::map<std::string, std::string>& sites);
std::string enrolment_json(const std::string& robot, const std::string& enrolment);

}  // namespace headframe
