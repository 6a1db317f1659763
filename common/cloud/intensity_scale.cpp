#include "common/cloud/intensity_scale.hpp"

#include <algorithm>
#include <cmath>

namespace headframe {
namespace {

constexpr float of_bytes = 255, of_words = 65535;
constexpr std::ptrdiff_t share_over = 100;  // one in so many may be over the full scale

bool is_over(const std::vector<float>& raw, float full) {
  const auto count = [&](float over) {
    return std::count_if(raw.begin(), raw.end(), [&](float value) { return std::isfinite(value) && value > over; });
  };
  return count(full) * share_over > count(0);
}

std::uint8_t to_byte(float value, float full) {
  if (!(value > 0)) return 0;
  const float share = std::min(value / full, 1.0F);
  return static_cast<std::uint8_t>(std::lround(of_bytes * (full == of_words ? std::sqrt(share) : share)));
}

}  // namespace

Intensities IntensityScale::scaled(const std::vector<float>& raw) {
  if (full_ < of_bytes && is_over(raw, full_)) full_ = of_bytes;
  if (full_ < of_words && is_over(raw, of_bytes)) full_ = of_words;
  Intensities out;
  out.reserve(raw.size());
  for (const float value : raw) out.push_back(std::isfinite(value) ? to_byte(value, full_) : std::uint8_t{0});
  if (std::all_of(out.begin(), out.end(), [](std::uint8_t value) { return value == 0; })) out.clear();
  return out;
}

}  // namespace headframe
