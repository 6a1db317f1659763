#include "server/place/likely_height.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace headframe {
namespace {

/// Told by two keyframes so far from each other, seen from above.
struct Height {
  double distance_m = std::numeric_limits<double>::max(), height_m = 0;
};

std::vector<Height> heights(std::span<const Keyframe> a, std::span<const Keyframe> b, const Pose& T_a_b) {
  std::vector<Height> out(b.size());
  for (std::size_t i = 0; i < b.size(); ++i) {
    const Eigen::Vector2d p = (T_a_b * position(b[i])).head<2>();
    const double z = (T_a_b.linear() * position(b[i])).z();
    for (const Keyframe& k : a)
      if (const double away_m = (position(k).head<2>() - p).norm(); away_m < out[i].distance_m)
        out[i] = {away_m, position(k).z() - z};
  }
  return out;
}

}  // namespace

double likely_height_m(std::span<const Keyframe> a, std::span<const Keyframe> b, const Pose& T_a_b,
                       std::optional<double> told_m) {
  constexpr double close_m = 4, same_level_m = 1;
  std::vector<Height> all = heights(a, b, T_a_b);
  const auto is_close = [&](const Height& h) { return h.distance_m < close_m; };
  if (std::ranges::none_of(all, is_close)) {
    const auto nearest = std::ranges::min_element(all, {}, &Height::distance_m);
    return told_m ? *told_m : nearest == all.end() ? 0 : nearest->height_m;
  }
  std::erase_if(all, [&](const Height& h) { return !is_close(h); });
  const auto agreeing = [&](const Height& h) {
    return std::ranges::count_if(all,
                                 [&](const Height& o) { return std::abs(o.height_m - h.height_m) < same_level_m; });
  };
  const auto worth = [&](const Height& h) {
    const double fits = told_m ? -std::floor(std::abs(h.height_m - *told_m)) : static_cast<double>(agreeing(h));
    return std::pair(fits, -h.distance_m);
  };
  return std::ranges::max_element(all, {}, worth)->height_m;
}

}  // namespace headframe
