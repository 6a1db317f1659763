#pragma once
// A keyframe's cloud as it travels and as it is stored.
//
// One zstd frame with its content size and checksum. Inside, numbers are LEB128 varints (signed ones zigzag) unless
// said otherwise:
//   form 1 or 2, cell_m (float32, little endian), number of sweeps, then per sweep:
//   origin in cells (3 signed), number of points; if there are points: lowest corner in cells (3 signed), and then
//   form 1: per point, in Morton order of (cell - corner), the difference to the Morton code before it (the first: to
//   0) form 2: the levels of its octree (octree_code.hpp). After all sweeps, their octrees as one range coded stream.
// or, where points have intensities:
//   form 3, number of bytes of the cloud without them, in form 1 or 2 as above, these bytes, and then the intensities
//   of all sweeps as one range coded stream (intensity_code.hpp).
// All are read. Form 2 is written, but for clouds of more than 262144 points or less than half a byte a point; the
// intensities of clouds of more than 262144 points are left out.

#include <string>
#include <string_view>

#include "common/cloud/point_cloud.hpp"
#include "common/result.hpp"

namespace headframe {

inline constexpr float default_cell_m = 0.01F;

/// Points and origins are rounded to the grid (error at most cell_m / 2 per axis) and reordered within their sweep;
/// none is dropped. Intensities go with their points and are rounded to 32 levels. Deterministic. Fails with
/// invalid_argument when a coordinate is not finite, a sweep is wider than 2^21 cells, it has neither as many
/// intensities as points nor none, or a limit of common/wire/limits.hpp is exceeded. Thread safe.
Result<std::string> encode_cloud(const KeyframeCloud& cloud, float cell_m = default_cell_m);

/// Bytes may be anything: memory is bounded by limits::cloud_points whatever they announce. bad_input when damaged.
/// Thread safe.
Result<KeyframeCloud> decode_cloud(std::string_view bytes);

/// The same without intensities, which are not looked at: for merging, which has no use for them. Thread safe.
Result<KeyframeCloud> decode_points(std::string_view bytes);

/// The encoded cloud as encode_cloud would have made it without intensities, for a reader that does not know form 3.
/// Its points are not looked at. bad_input when damaged. Thread safe.
Result<std::string> without_intensity(std::string_view bytes);

}  // namespace headframe
