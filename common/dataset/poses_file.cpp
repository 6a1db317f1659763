#include "common/dataset/poses_file.hpp"

#include <array>
#include <cmath>

#include "common/dataset/text.hpp"

namespace headframe::dataset {
namespace {

constexpr double least_quaternion = 1e-6;  // a shorter one has no direction

Result<StampedPose> parse_pose(std::string_view line) {
  const auto parts = words(line);
  if (parts.size() != 8)
    return failure(ErrorCode::bad_input, std::to_string(parts.size()) + " values, a pose has 8: t x y z qx qy qz qw");
  std::array<double, 8> v{};
  for (std::size_t i = 0; i < v.size(); ++i) {
    const auto value = to_number(parts[i]);
    if (!value || !std::isfinite(*value))
      return failure(ErrorCode::bad_input, in_quotes(parts[i]) + " is no finite number");
    v[i] = *value;
  }
  const Eigen::Quaterniond q(v[7], v[4], v[5], v[6]);
  const double length = q.coeffs().stableNorm();
  if (length < least_quaternion) return failure(ErrorCode::bad_input, "the quaternion has length zero");
  StampedPose pose{v[0], Pose::Identity()};
  pose.T_local_sensor.linear() = Eigen::Quaterniond(q.coeffs() / length).toRotationMatrix();
  pose.T_local_sensor.translation() = Eigen::Vector3d(v[1], v[2], v[3]);
  return pose;
}

}  // namespace

Result<std::vector<StampedPose>> parse_poses(std::string_view text) {
  std::vector<StampedPose> poses;
  Lines lines(text);
  while (const auto line = lines.next()) {
    const std::size_t start = line->find_first_not_of(" \t");
    if (start == std::string_view::npos || (*line)[start] == '#') continue;
    auto pose = parse_pose(*line);
    if (pose && !poses.empty() && pose->stamp_s <= poses.back().stamp_s)
      pose = failure(ErrorCode::bad_input, "stamp " + std::string(words(*line)[0]) + " is not after the one before");
    if (!pose)
      return failure(pose.error().code, "line " + std::to_string(lines.number()) + ": " + pose.error().message);
    poses.push_back(*pose);
  }
  return poses;
}

}  // namespace headframe::dataset
