#include "server/place/odometry_jump.hpp"

#include <cmath>

namespace headframe {
namespace {

constexpr double farthest_m = 25, fastest_m_s = 30, least_fast_m = 8;
constexpr double least_climb_m = 4, most_climb_m = 10, slowest_climb_m_s = 0.3, fastest_climb_m_s = 5;

std::string whole(double value) { return std::to_string(std::llround(value)); }

}  // namespace

std::optional<std::string> jump_between(const Keyframe& before, const Keyframe& after) {
  const Eigen::Vector3d step = after.T_local_sensor.translation() - before.T_local_sensor.translation();
  const double step_m = step.norm(), level_m = step.head<2>().norm(), time_s = after.stamp_s - before.stamp_s;
  const std::string where = "between keyframes " + std::to_string(before.sequence) + " and " +
                            std::to_string(after.sequence) + " its odometry jumps ";
  if (step_m > farthest_m) return where + whole(step_m) + " m";
  if (time_s > 0 && step_m > least_fast_m && step_m > fastest_m_s * time_s) return where + whole(step_m) + " m at once";
  const double climb_m = std::abs(step.z());
  const bool flown =
      climb_m <= most_climb_m && climb_m >= slowest_climb_m_s * time_s && climb_m <= fastest_climb_m_s * time_s;
  if (climb_m > least_climb_m && climb_m > level_m && !flown)
    return where + whole(climb_m) + (step.z() > 0 ? " m up" : " m down");
  return std::nullopt;
}

}  // namespace headframe
