#pragma once
// The demo's picture: the maps as the robots know them, and as the server merged them.

#include <filesystem>
#include <vector>

#include "common/result.hpp"
#include "tests/mine/demo/outcome.hpp"

namespace headframe::demo {

/// Draws the session folders under `recordings` into a PNG file; maps that did not merge are left out of the right
/// half. Fails as SessionFolder does, or when the picture cannot be written.
Result<void> draw_before_after(const std::filesystem::path& recordings, const std::vector<RobotOutcome>& robots,
                               const std::filesystem::path& png);

}  // namespace headframe::demo
