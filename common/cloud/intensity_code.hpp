#pragma once
// Compresses the intensities of a cloud's points: 32 levels, each coded with the previous one as context. Most returns
// are faint, and people perceive equal steps of the square root as about equal, so the levels follow the square root.

#include <array>
#include <span>

#include "common/cloud/point_cloud.hpp"
#include "common/cloud/range_coder.hpp"

namespace headframe {

inline constexpr int intensity_bits = 5;
inline constexpr std::size_t intensity_levels = std::size_t{1} << intensity_bits;

/// The level nearest to 31 sqrt(intensity / 255).
std::uint8_t intensity_level(std::uint8_t intensity);
/// The intensity that a level, which is below 32, is decoded to: the one nearest to 255 (level / 31)^2.
std::uint8_t intensity_of_level(std::uint8_t level);

/// Learned probabilities of levels; shared by the sweeps of one cloud.
struct IntensityModel {
  std::array<std::array<AdaptiveBit, intensity_levels>, intensity_levels>
      bits;  // [level before][1 and the bits before]
};

class IntensityEncoder {
 public:
  /// The levels of one sweep in the order of its points; empty if the sweep has no intensities.
  void put(std::span<const std::uint8_t> levels);
  std::string finish() { return coder_.finish(); }

 private:
  IntensityModel model_;
  RangeEncoder coder_;
};

/// Accepts any bytes; work and memory are bounded by the number of points requested.
class IntensityDecoder {
 public:
  explicit IntensityDecoder(std::string_view bytes) : coder_(bytes) {}

  /// Reads the intensities of the next sweep, which has `points` points, at least one. Returns as many, or none if the
  /// sweep has no intensities. False: there are no more bytes.
  bool get(std::size_t points, Intensities& intensity);
  /// Whether exactly all bytes were read.
  bool done() const { return coder_.done(); }

 private:
  IntensityModel model_;
  RangeDecoder coder_;
};

}  // namespace headframe
