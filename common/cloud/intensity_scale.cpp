#include "common/cloud/intensity_scale.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace headframe {
namespace {

constexpr float of_bytes = 255, of_words = 65535;
constexpr std::size_t share_over = 100;  // one in this many may exceed the full scale

bool is_over(const std::vector<float>& raw, float full) {
  std::size_t returns = 0, over = 0;
  for (const float value : raw) {
    const bool is_number = value <= std::numeric_limits<float>::max();
    returns += is_number && value > 0 ? 1 : 0;
    over += is_number && value > full ? 1 : 0;
  }
  return over * share_over > returns;
}

std::uint8_t to_byte(float value, float full) {
  if (!(value > 0 && value <= std::numeric_limits<float>::max())) return 0;
  const float share = std::min(value / full, 1.0F);
  return static_cast<std::uint8_t>(std::lround(of_bytes * (full == of_words ? std::sqrt(share) : share)));
}

}  // namespace

Intensities IntensityScale::scaled(const std::vector<float>& raw) {
  if (full_ < of_bytes && is_over(raw, full_)) full_ = of_bytes;
  if (full_ < of_words && is_over(raw, of_bytes)) full_ = of_words;
  Intensities out;
  out.reserve(raw.size());
  for (const float value : raw) out.push_back(to_byte(value, full_));
  if (std::all_of(out.begin(), out.end(), [](std::uint8_t value) { return value == 0; })) out.clear();
  return out;
}

}  // namespace headframe
