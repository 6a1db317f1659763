#pragma once
// Compares signatures w. They have the same meaning in every family, so neither the family nor its network is needed.

#include <cstddef>
#include <vector>

namespace headframe {

struct YawScore {
  double yaw_rad = 0;  // yaw of frame b in frame a: turning b by it lines it up with a
  double score = 0;    // greater is better; comparable within one call
};

/// Peaks of the circular cross-correlation of two signatures over azimuth (counted from x towards y), best first, at
/// least 20 deg apart and at most `most`. Empty when the lengths differ or there is nothing to compare. Thread safe.
std::vector<YawScore> correlate_circular(const std::vector<float>& w_a, const std::vector<float>& w_b,
                                         std::size_t most);

}  // namespace headframe
