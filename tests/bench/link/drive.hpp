#pragma once
// A robot whose every keyframe follows from its name and number, so that what arrives can be compared bit for bit.

#include <cstdint>
#include <string>

#include "client/robot_client.hpp"

namespace headframe::bench {

inline constexpr int cloud_points = 6000;  // some 14 KB: two chunks

/// Descriptors of its own, every cloud sent. Without an enrolment in plain TCP, to a server on the loopback that runs
/// so.
RobotConfig drive_config(const std::string& robot, const std::filesystem::path& spool, const std::string& host,
                         std::uint16_t port, const std::string& enrolment = "");

/// Adds keyframe `number` (from 1) of the drive of `robot`, its cloud of about `points` points.
Result<bool> add_drive_keyframe(RobotClient& client, const std::string& robot, std::uint64_t number,
                                int points = cloud_points);

}  // namespace headframe::bench
