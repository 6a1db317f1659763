#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace headframe::bench {

/// Our GICP against PCL's on a pair of scans, both from identity. Every round runs all of them in turn; a ratio is the
/// median over the rounds of ratios within one round.
nlohmann::json registration(const std::filesystem::path& recordings);

/// Spheres of 25 m from maps of 1, 10 and 100 million points.
nlohmann::json sampling();

}  // namespace headframe::bench
