#pragma once
// The mine of the demo and the three drives in it.

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace headframe::demo {

struct DemoRobot {
  std::string name;
  std::string sensor;
  double frame_yaw_deg;
  std::vector<std::size_t> way;  // nodes of the mine
};

/// Three robots that share some drifts, mostly driving the other way, and have others to themselves.
const std::vector<DemoRobot>& demo_robots();

/// Writes the session folders DIR/NAME and DIR/truth.json. What an earlier run of the same version wrote is kept: then
/// it returns false. Fails when a file cannot be written.
Result<bool> prepare_recordings(const std::filesystem::path& dir);

}  // namespace headframe::demo
