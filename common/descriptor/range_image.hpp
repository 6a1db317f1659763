#pragma once
// A scan as an image over azimuth and elevation: the input of networks.

#include <cstddef>
#include <vector>

#include "common/cloud/point_cloud.hpp"

namespace headframe {

/// Rows go down from top_deg to bottom_deg in equal steps of elevation; columns go round from azimuth 0 (x) towards y.
/// (FRAME's projection starts at azimuth pi and goes the other way; here a column is a sector as in the other families,
/// so that the same correlation works for all.) Columns are cyclic: the last is next to the first.
struct RangeImageSpec {
  std::size_t rows = 16;
  std::size_t columns = 256;
  double top_deg = 11.2;  // the field of view that 16 and 32 beam lidars share
  double bottom_deg = -11.2;
};

struct RangeImage {
  RangeImageSpec spec;
  std::vector<float> range_m;  // row by row; 0: no return

  float& at(std::size_t row, std::size_t column) { return range_m[row * spec.columns + column]; }
  float at(std::size_t row, std::size_t column) const { return range_m[row * spec.columns + column]; }
};

/// points_level: levelled sensor frame, finite. A pixel holds the geometric mean of its points' ranges; points above or
/// below the rows are ignored.
RangeImage range_image(const Points& points_level, const RangeImageSpec& spec);

/// Fills holes of at most `rows` rows between two pixels of a column, then of at most `columns` columns between two of
/// a row, by linear interpolation of the logarithm. This makes lidars of 16 and of 32 beams look alike.
void fill_small_holes(RangeImage& image, std::size_t rows, std::size_t columns);

/// Two channels, each row by row: log(range / 5 m) / 1.5 with ranges clamped to 0.5 to 60 m, or 0 without a range; and
/// 1 for a pixel with a range, else 0.
std::vector<float> log_range_and_mask(const RangeImage& image);

/// Share of the pixels that hold a range, 0 to 1.
double seen_share(const RangeImage& image);

}  // namespace headframe
