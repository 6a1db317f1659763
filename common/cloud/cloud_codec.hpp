#pragma once
// The encoding of a keyframe's cloud, for sending and for storing.
//
// One zstd frame with its content size and checksum. Its content (numbers are LEB128 varints, signed ones zigzag,
// unless said otherwise):
//   form 1 or 2, cell_m (float32, little endian), number of sweeps, then for each sweep:
//   origin in cells (3 signed), number of points, and if there are points the lowest corner in cells (3 signed), then
//   form 1: for each point, in Morton order of (cell - corner), the difference to the previous Morton code (at first 0)
//   form 2: the number of levels of its octree (octree_code.hpp)
//   and in form 2, after all sweeps, their octrees as one range coded stream.
// If points have intensities:
//   form 3, size in bytes of the cloud without them, that cloud in form 1 or 2, and then the intensities of all sweeps
//   as one range coded stream (intensity_code.hpp).
// All forms are read. The encoder writes form 2, except for clouds with more than 262144 points or with less than half
// a byte for each point; it omits the intensities of clouds with more than 262144 points.

#include <string>
#include <string_view>

#include "common/cloud/point_cloud.hpp"
#include "common/result.hpp"

namespace headframe {

inline constexpr float default_cell_m = 0.01F;

/// Points and origins are rounded to the grid (error at most cell_m / 2 on each axis) and reordered within their sweep;
/// none is dropped. Intensities stay with their points and are rounded to 32 levels. Deterministic. invalid_argument: a
/// coordinate is not finite, a sweep is wider than 2^21 cells or has intensities for only some points, or a limit of
/// common/wire/limits.hpp is exceeded. Thread safe.
Result<std::string> encode_cloud(const KeyframeCloud& cloud, float cell_m = default_cell_m);

/// Accepts any bytes: memory is bounded by limits::cloud_points whatever they claim. bad_input: damaged. Thread safe.
Result<KeyframeCloud> decode_cloud(std::string_view bytes);

/// The same without intensities, which are not decoded; for merging, which does not use them. Thread safe.
Result<KeyframeCloud> decode_points(std::string_view bytes);

/// What encode_cloud would have made without intensities, for a reader that does not know form 3. Does not decode the
/// points. bad_input: damaged. Thread safe.
Result<std::string> without_intensity(std::string_view bytes);

}  // namespace headframe
