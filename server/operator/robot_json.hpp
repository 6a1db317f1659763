#pragma once
// The JSON of robots and enrolments. Pure.

#include "server/station/robot_admin.hpp"

namespace headframe {

std::string robots_json(const std::vector<RobotRow>& robots, const std::string& fingerprint,
                        const std::string& address);
std::string enrolment_json(const std::string& robot, const std::string& enrolment);

}  // namespace headframe
