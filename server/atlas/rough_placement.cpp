#include "server/atlas/rough_placement.hpp"

#include <cmath>
#include <numbers>
#include <string>

namespace headframe {
namespace {

constexpr std::size_t least_pairs = 3;
constexpr double most_coordinate_m = 1e8, least_spread_m = 1, most_rms_m = 5;

bool is_sound(const Eigen::Vector3d& p_m) { return p_m.allFinite() && p_m.cwiseAbs().maxCoeff() <= most_coordinate_m; }

tl::unexpected<Error> refused(const std::string& why) { return failure(ErrorCode::invalid_argument, why); }

std::string tenths(double metres) {
  const std::string text = std::to_string(std::round(metres * 10) / 10);
  return text.substr(0, text.find('.') + 2) + " m";
}

}  // namespace

Result<Pose> rough_placement(std::span<const PointPair> pairs) {
  if (pairs.size() < least_pairs)
    return refused("give three pairs of points or more, there are " + std::to_string(pairs.size()));
  const auto count = static_cast<double>(pairs.size());
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero(), mean_b = mean_a;
  for (const PointPair& pair : pairs) {
    if (!is_sound(pair.p_a_m) || !is_sound(pair.p_b_m))
      return refused("a point has a number that is not finite, or lies beyond 100000 km");
    mean_a += pair.p_a_m / count;
    mean_b += pair.p_b_m / count;
  }
  double along = 0, across = 0, spread_a = 0, spread_b = 0;
  for (const PointPair& pair : pairs) {
    const Eigen::Vector2d a = (pair.p_a_m - mean_a).head<2>(), b = (pair.p_b_m - mean_b).head<2>();
    along += b.dot(a);
    across += b.x() * a.y() - b.y() * a.x();
    spread_a += a.squaredNorm() / count;
    spread_b += b.squaredNorm() / count;
  }
  if (std::sqrt(std::min(spread_a, spread_b)) < least_spread_m)
    return refused(
        "the points lie within a metre of one spot, where the turn would be a guess; choose some farther apart");
  const Pose T_turn = pose_from_yaw(std::atan2(across, along), {0, 0, 0});
  const Pose T_a_b = pose_from_yaw(std::atan2(across, along), mean_a - T_turn * mean_b);
  double squared = 0;
  for (const PointPair& pair : pairs) squared += (T_a_b * pair.p_b_m - pair.p_a_m).squaredNorm() / count;
  if (const double rms_m = std::sqrt(squared); rms_m > most_rms_m)
    return refused("the pairs contradict each other by " + tenths(rms_m) + "; is one of them another spot?");
  return T_a_b;
}

Result<Pose> rough_placement(const Eigen::Vector3d& p_a_m, double yaw_deg) {
  if (!is_sound(p_a_m) || !std::isfinite(yaw_deg) || std::abs(yaw_deg) > 3600)
    return refused("x, y, z and yaw are metres within 100000 km and degrees");
  return pose_from_yaw(yaw_deg * std::numbers::pi / 180, p_a_m);
}

}  // namespace headframe
