#pragma once
// Recordings as session folders: scans, poses, sensor and truth in the form that headframe-replay plays.

#include <filesystem>
#include <string>
#include <vector>

#include "tests/mine/scenario.hpp"

namespace headframe::mine {

/// Writes DIR/NAME/{scans/NNNNNN.bin,poses.txt,sensor.json} for each recording, DIR/truth/NAME.txt and DIR/truth.json.
/// What was there under the same names is replaced. Fails (unavailable) when a file cannot be written.
Result<void> write_recordings(const std::filesystem::path& dir, const std::string& title, const std::string& world,
                              const std::vector<Recording>& recordings);

/// One TUM line per pose: t x y z qx qy qz qw, with t growing by 1 s per metre.
std::string tum_text(const std::vector<Pose>& poses, double scan_spacing_m);

}  // namespace headframe::mine
