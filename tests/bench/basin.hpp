#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace headframe::bench {

/// FRAME's experiment on where registration still finds the truth: success over the yaw error and the distance that the
/// start is off, for spheres of 5 to 30 m in simulated mines, by GICP and VGICP. Draws basin.png into `out`.
nlohmann::json basin(const std::filesystem::path& out);

}  // namespace headframe::bench
