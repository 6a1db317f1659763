#pragma once
// The intensities of a cloud's points as few bytes: 32 levels, each coded with what is known of it from the one before.
// Returns are mostly faint, and a person sees steps of the square root as about equal: so do the levels.

#include <array>
#include <span>

#include "common/cloud/point_cloud.hpp"
#include "common/cloud/range_coder.hpp"

namespace headframe {

inline constexpr int intensity_bits = 5;
inline constexpr std::size_t intensity_levels = std::size_t{1} << intensity_bits;

/// The level nearest to 31 sqrt(intensity / 255).
std::uint8_t intensity_level(std::uint8_t intensity);
/// What is read of a level, which is below 32: the intensity nearest to 255 (level / 31)^2.
std::uint8_t intensity_of_level(std::uint8_t level);

/// What was learned of levels; shared by the sweeps of one cloud.
struct IntensityModel {
  std::array<std::array<AdaptiveBit, intensity_levels>, intensity_levels>
      bits;  // [level before][1 and the bits before]
};

class IntensityEncoder {
 public:
  /// The levels of one sweep in the order of its points, or none: the sweep has no intensities.
  void put(std::span<const std::uint8_t> levels);
  std::string finish() { return coder_.finish(); }

 private:
  IntensityModel model_;
  RangeEncoder coder_;
};

/// Takes any bytes; work and memory are bounded by the points that are asked for.
class IntensityDecoder {
 public:
  explicit IntensityDecoder(std::string_view bytes) : coder_(bytes) {}

  /// Of the next sweep, which has so many points, at least one: as many, or none where it has no intensities. False:
  /// the bytes have come to their end.
  bool get(std::size_t points, Intensities& intensity);
  /// All bytes were read, and no more.
  bool done() const { return coder_.done(); }

 private:
  IntensityModel model_;
  RangeDecoder coder_;
};

}  // namespace headframe
