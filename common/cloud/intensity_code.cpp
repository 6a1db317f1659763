#include "common/cloud/intensity_code.hpp"

#include <cmath>

namespace headframe {
namespace {

constexpr double most = 255, top_level = intensity_levels - 1;

}  // namespace

std::uint8_t intensity_level(std::uint8_t intensity) {
  static const auto levels = [] {
    std::array<std::uint8_t, 256> all{};
    for (std::size_t i = 0; i < all.size(); ++i)
      all.at(i) = static_cast<std::uint8_t>(std::lround(top_level * std::sqrt(static_cast<double>(i) / most)));
    return all;
  }();
  return levels.at(intensity);
}

std::uint8_t intensity_of_level(std::uint8_t level) {
  const double share = level / top_level;
  return static_cast<std::uint8_t>(std::lround(most * share * share));
}

void IntensityEncoder::put(std::span<const std::uint8_t> levels) {
  coder_.put_plain(levels.empty() ? 0 : 1, 1);
  std::size_t before = 0;
  for (const std::uint8_t level : levels) {
    auto& bits = model_.bits.at(before);
    std::size_t pattern = 1;
    for (int i = intensity_bits - 1; i >= 0; --i) {
      const bool bit = (level >> i & 1) != 0;
      coder_.put(bits.at(pattern), bit);
      pattern = pattern << 1 | (bit ? 1U : 0U);
    }
    before = level;
  }
}

bool IntensityDecoder::get(std::size_t points, Intensities& intensity) {
  intensity.clear();
  if (coder_.get_plain(1) == 0) return !coder_.overrun();
  intensity.reserve(points);
  std::size_t before = 0;
  while (intensity.size() < points && !coder_.overrun()) {
    auto& bits = model_.bits.at(before);
    std::size_t pattern = 1;
    for (int i = 0; i < intensity_bits; ++i) pattern = pattern << 1 | (coder_.get(bits.at(pattern)) ? 1U : 0U);
    before = pattern - intensity_levels;
    intensity.push_back(intensity_of_level(static_cast<std::uint8_t>(before)));
  }
  return !coder_.overrun();
}

}  // namespace headframe
