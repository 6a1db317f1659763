#include "common/descriptor/level.hpp"

namespace headframe {

Pose level_from_sensor(const Pose& T_local_sensor) { return levelled(T_local_sensor).inverse() * T_local_sensor; }

Points level(const Pose& T_local_sensor, const Points& points_sensor) {
  const Eigen::Isometry3f T_level_sensor = level_from_sensor(T_local_sensor).cast<float>();
  Points points_level;
  points_level.reserve(points_sensor.size());
  for (const auto& p : points_sensor) points_level.push_back(T_level_sensor * p);
  return points_level;
}

}  // namespace headframe
