#include "server/place/wall_signature.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

namespace headframe {
namespace {

constexpr std::ptrdiff_t least_returns = 20;

using Complex = std::complex<float>;

/// exp(-2 pi i n / 180).
const std::array<Complex, WallProfile::sectors>& unit_roots() {
  static const auto roots = [] {
    std::array<Complex, WallProfile::sectors> out;
    for (std::size_t n = 0; n < out.size(); ++n) {
      const double angle_rad = -2 * std::numbers::pi * static_cast<double>(n) / WallProfile::sectors;
      out[n] = {static_cast<float>(std::cos(angle_rad)), static_cast<float>(std::sin(angle_rad))};
    }
    return out;
  }();
  return roots;
}

}  // namespace

std::optional<std::vector<float>> wall_signature(const WallProfile& walls) {
  const auto returns = std::count_if(walls.code.begin(), walls.code.end(), [](std::uint8_t code) { return code > 0; });
  if (returns < least_returns) return std::nullopt;
  const std::uint8_t farthest = *std::max_element(walls.code.begin(), walls.code.end());
  const auto& roots = unit_roots();
  std::vector<float> signature;
  signature.reserve(wall_signature_size);
  for (std::size_t harmonic = 0; harmonic < wall_signature_size; ++harmonic) {
    Complex sum = 0;
    for (std::size_t i = 0; i < WallProfile::sectors; ++i) {
      const auto code = static_cast<float>(walls.code[i] > 0 ? walls.code[i] : farthest);
      sum += code * roots[harmonic * i % WallProfile::sectors];
    }
    signature.push_back(std::sqrt(harmonic == 0 ? std::abs(sum) / 2 : std::abs(sum)));
  }
  return signature;
}

}  // namespace headframe
