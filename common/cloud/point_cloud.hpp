#pragma once
// Point clouds, in metres, in the frame named by the variable.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace headframe {

using Points = std::vector<Eigen::Vector3f>;

/// Intensities of the points' returns, 0 to 255, in the order of the points. Empty: the sensor gave none.
using Intensities = std::vector<std::uint8_t>;

/// Points with the intensities of their returns.
struct Returns {
  Points points;
  Intensities intensity = {};  // as many, or empty
};

/// Points seen from one position. The origin is the sensor's position, which is needed to trace rays (free space).
struct Sweep {
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  Points points;
  Intensities intensity = {};  // as many as points, or empty
};

/// What a robot saw since the last keyframe, in the keyframe's sensor frame: the last sweep is the keyframe's own scan
/// (origin zero), the others were taken on the way to it.
struct KeyframeCloud {
  std::vector<Sweep> sweeps;
};

std::size_t point_count(const KeyframeCloud& cloud);

/// Drops NaN, infinite points, and those nearer than min_range_m, such as the zeros that drivers write for no return.
Points finite_points(const Points& points, float min_range_m);
/// The same with intensities, one for each point or none.
Returns finite_points(const Points& points, const Intensities& intensity, float min_range_m);

/// One point per cube of leaf_m: the mean of the points in it. Deterministic: cubes come in the order of their first
/// point. leaf_m > 0; points must be finite and within 1e6 leaves of the origin (others are dropped).
Points voxel_grid(const Points& points, float leaf_m);
/// The same with the mean of the intensities in each cube; one for each point or none.
Returns voxel_grid(const Points& points, const Intensities& intensity, float leaf_m);

}  // namespace headframe
