#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/cloud/point_cloud.hpp"

namespace headframe {

/// What one sweep says of a point in space.
enum class Sight : std::uint8_t {
  unknown,  // outside the field of view, out of range, or hidden behind a surface
  hit,      // the sweep hit a surface there
  through,  // its rays passed through the point: the place is free
};

/// Whether something that `hits` of a session's sweeps hit, and `through` of them saw through, was there only for a
/// moment: dust, people, vehicles that drove on. Rock is hit at least least_hits times.
constexpr bool is_transient(int hits, int through, int least_hits) {
  return hits < least_hits || (through > 0 && through >= hits);
}

/// Up to `most` points, coordinate by coordinate, so that several are computed at once.
struct SightBlock {
  static constexpr std::size_t most = 64;
  std::size_t count = 0;
  std::array<float, most> x, y, z;

  void add(const Eigen::Vector3f& p) {
    x[count] = p.x();
    y[count] = p.y();
    z[count++] = p.z();
  }
};

/// The ranges of one sweep in bins of 2 x 2 deg, to tell whether a point is hit, seen through or hidden. Made for
/// lidars of 16 to 128 beams. A bin without a return knows nothing, and rows without a return take no memory. Immutable
/// after construction.
class SightImage {
 public:
  static constexpr int columns = 180;
  static constexpr int rows = 45;  // -45 to +45 deg

  /// Points in the frame of the sweep's sensor (origin at the sensor).
  explicit SightImage(const Points& points);

  /// Up to a range of reach_m. The tolerance grows with the range: 0.35 m + 3 %, and slack_m for odometry that drifted
  /// between the sweep and the point.
  Sight look(const Eigen::Vector3f& point, float reach_m, float slack_m = 0) const;

  /// The same of all points of a block, faster than one by one; one answer for each.
  void look(const SightBlock& points, float reach_m, std::span<Sight, SightBlock::most> answers,
            float slack_m = 0) const;

  std::size_t bytes() const { return bins_.size() * sizeof(Bin); }

 private:
  struct Bin {
    std::uint16_t near_cm = 0;  // 0: no return
    std::uint16_t far_cm = 0;
    std::uint16_t nearest_cm = 0, farthest_cm = 0;  // of this bin and the eight around it
  };
  struct Direction {
    int column = 0, row = 0;
  };
  static Direction direction(float x, float y, float z);
  bool meets_around(int row, int column, float range, float tolerance) const;
  void sum_up(int row, int column);
  const Bin& bin(int row, int column) const;

  int first_row_ = 0, end_row_ = 0;
  std::vector<Bin> bins_;  // of rows first_row_ to end_row_, and one without a return for what lies elsewhere
};

}  // namespace headframe
