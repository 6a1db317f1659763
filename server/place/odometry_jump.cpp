#include "server/place/odometry_jump.hpp"

#include <algorithm>
#include <cmath>

#include "server/place/sanity.hpp"

namespace headframe {
namespace {

constexpr double farthest_m = 25, fastest_m_s = 30, least_fast_m = 8;
constexpr double least_climb_m = 4, most_climb_m = 10, slowest_climb_m_s = 0.3, fastest_climb_m_s = 5;  // of a drone
// KeyframeSelector makes no keyframe within 10 m of another (less in narrow tunnels), but makes one at the next scan
// beyond.
constexpr double beside_m = 12;
constexpr double sees_the_same = 0.65;  // of the walls: less is a scan from elsewhere (sanity.cpp)

bool climbs(const Eigen::Vector3d& step) {
  return std::abs(step.z()) > least_climb_m && std::abs(step.z()) > step.head<2>().norm();
}

bool flown(double climb_m, double time_s) {
  return climb_m <= most_climb_m && climb_m >= slowest_climb_m_s * time_s && climb_m <= fastest_climb_m_s * time_s;
}

/// Whether the robot came back to its own path: beside an earlier keyframe that saw the same walls.
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
  const double step_m = step.norm(), climb_m = std::abs(step.z()), time_s = after.stamp_s - before.stamp_s;
  const std::string where = "its odometry jumps ";
  if (time_s > 0 && step_m > least_fast_m && step_m > fastest_m_s * time_s) return where + whole(step_m) + " m at once";
  const bool far = step_m > farthest_m, up = climbs(step) && !flown(climb_m, time_s);
  if ((!far && !up) || beside_one_of(earlier, after)) return std::nullopt;
  return far ? where + whole(step_m) + " m" : where + whole(climb_m) + (step.z() > 0 ? " m up" : " m down");
}

}  // namespace headframe
