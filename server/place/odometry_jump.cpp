#include "server/place/odometry_jump.hpp"

#include <algorithm>
#include <cmath>

#include "server/place/sanity.hpp"

namespace headframe {
namespace {

constexpr double farthest_m = 25, fastest_m_s = 30, least_fast_m = 8, least_climb_m = 4;

// The selection makes no keyframe within 10 m of another, or less in narrow drifts, and a scan later there is one.
constexpr double beside_m = 12;
constexpr double sees_the_same = 0.65;  // of the walls: less is a scan from elsewhere (sanity.cpp)

bool climbs(const Eigen::Vector3d& step) {
  return std::abs(step.z()) > least_climb_m && std::abs(step.z()) > step.head<2>().norm();
}

/// Whether the robot came back to its own path before: beside a keyframe that saw the same walls.
bool beside_one_of(std::span<const Keyframe> earlier, const Keyframe& after) {
  return std::any_of(earlier.begin(), earlier.end(), [&](const Keyframe& k) {
    const Eigen::Vector3d step = after.T_local_sensor.translation() - k.T_local_sensor.translation();
    if (step.norm() > beside_m || climbs(step)) return false;
    const auto there = agreement(k, after), back = agreement(after, k);
    return there && back && std::min(*there, *back) >= sees_the_same;
  });
}

std::string whole(double value) { return std::to_string(std::llround(value)); }

}  // namespace

std::optional<std::string> jump_between(const Keyframe& before, const Keyframe& after,
                                        std::span<const Keyframe> earlier) {
  const Eigen::Vector3d step = after.T_local_sensor.translation() - before.T_local_sensor.translation();
  const double step_m = step.norm(), time_s = after.stamp_s - before.stamp_s;
  const std::string where = "between keyframes " + std::to_string(before.sequence) + " and " +
                            std::to_string(after.sequence) + " its odometry jumps ";
  if (time_s > 0 && step_m > least_fast_m && step_m > fastest_m_s * time_s) return where + whole(step_m) + " m at once";
  const bool far = step_m > farthest_m;
  if ((!far && !climbs(step)) || beside_one_of(earlier, after)) return std::nullopt;
  if (far) return where + whole(step_m) + " m";
  return where + whole(std::abs(step.z())) + (step.z() > 0 ? " m up" : " m down");
}

}  // namespace headframe
