#pragma once
// Clouds of points, in metres, in the frame that the variable's name says.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace headframe {

using Points = std::vector<Eigen::Vector3f>;

/// How strong the returns of points were, 0 to 255, in the order of the points. Empty: the sensor gave none.
using Intensities = std::vector<std::uint8_t>;

/// Points with what came back from each.
struct Returns {
  Points points;
  Intensities intensity = {};  // as many, or empty
};

/// Points seen from one place. The origin is where the sensor stood, so that rays can be drawn (free space).
struct Sweep {
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  Points points;
  Intensities intensity = {};  // as many as points, or empty
};

/// What a robot saw on the way to a keyframe, in the keyframe's sensor frame: the keyframe's own scan is the last sweep
/// (origin zero), the ones before it were taken since the previous keyframe.
struct KeyframeCloud {
  std::vector<Sweep> sweeps;
};

std::size_t point_count(const KeyframeCloud& cloud);

/// Points without NaN, infinity, or the zeros that drivers write for "no return" (nearer than min_range_m).
Points finite_points(const Points& points, float min_range_m);
/// The same points with their intensities, which are as many or none.
Returns finite_points(const Points& points, const Intensities& intensity, float min_range_m);

/// One point per cube of leaf_m: the mean of the points in it. Deterministic: cubes come in the order of their first
/// point. leaf_m > 0; points must be finite and within 1e6 leaves of the origin (others are dropped).
Points voxel_grid(const Points& points, float leaf_m);
/// The same points with the mean of the intensities in each cube, which are as many as points or none.
Returns voxel_grid(const Points& points, const Intensities& intensity, float leaf_m);

}  // namespace headframe
