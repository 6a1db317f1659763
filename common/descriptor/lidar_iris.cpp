#include "common/descriptor/lidar_iris.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace headframe {
namespace {

constexpr std::size_t rings = 80, groups = 20, sectors = 360, filters = 4, w_bins = 72;
constexpr float nearest_m = 0.5F, farthest_m = 60.0F;
constexpr float layer_m = 0.75F;
constexpr int layers = 8;  // half of them below the sensor

// From the paper: the shortest wavelength in sectors, the factor to the next filter's, and the width of a filter's bell
// over log frequency.
constexpr float shortest_wave = 18, next_wave = 1.6F, spread = 0.75F;
constexpr float quiet = 0.02F;  // responses below this share of a full cell set no bit: empty rings stay empty

using Row = std::vector<float>;
using Spectrum = std::vector<std::complex<float>>;

std::vector<Row> draw(const Points& points) {
  std::vector<std::array<unsigned, sectors>> bits(rings);
  for (const auto& p : points) {
    const float r = std::hypot(p.x(), p.y());
    if (r < nearest_m || r >= farthest_m) continue;
    const float ring = std::log(r / nearest_m) / std::log(farthest_m / nearest_m) * rings;
    const float turn = std::atan2(p.y(), p.x()) / (2 * std::numbers::pi_v<float>);
    const auto sector = static_cast<std::size_t>((turn < 0 ? turn + 1 : turn) * sectors) % sectors;
    const int layer = static_cast<int>(std::floor(std::clamp(p.z() / layer_m, -100.0F, 100.0F))) + layers / 2;
    bits[std::min(static_cast<std::size_t>(ring), rings - 1)][sector] |= 1U << std::clamp(layer, 0, layers - 1);
  }
  std::vector<Row> image(rings, Row(sectors));
  for (std::size_t i = 0; i < rings; ++i)
    for (std::size_t s = 0; s < sectors; ++s) image[i][s] = static_cast<float>(bits[i][s]) / 255.0F;
  return image;
}

/// A filter's gain for each frequency (waves a turn).
Row gains_of(std::size_t filter) {
  const float middle = sectors / (shortest_wave * std::pow(next_wave, static_cast<float>(filter)));
  Row gains(sectors / 2, 0);
  for (std::size_t k = 1; k < gains.size(); ++k) {
    const float u = std::log(static_cast<float>(k) / middle) / std::log(spread);
    gains[k] = std::exp(-0.5F * u * u);
  }
  return gains;
}

/// The filter's complex response. Only positive frequencies are used, so that its modulus does not oscillate.
Spectrum filtered(Eigen::FFT<float>& fft, const Spectrum& spectrum, const Row& gains) {
  Spectrum kept(sectors), response;
  for (std::size_t k = 1; k < gains.size(); ++k) kept[k] = 2 * gains[k] * spectrum[k];
  fft.inv(response, kept);
  return response;
}

}  // namespace

Result<Descriptor> LidarIris::extract(const Points& points_level) const {
  if (auto enough = enough_points(points_level); !enough) return tl::unexpected(enough.error());
  static const std::array<Row, filters> gains{gains_of(0), gains_of(1), gains_of(2), gains_of(3)};
  constexpr auto rings_a_group = static_cast<float>(rings) / groups;
  Descriptor d;
  d.q.assign(groups * filters, 0);
  d.w.assign(w_bins, 0);
  Eigen::FFT<float> fft;
  const std::vector<Row> image = draw(points_level);
  for (std::size_t ring = 0; ring < rings; ++ring) {
    if (std::all_of(image[ring].begin(), image[ring].end(), [](float cell) { return cell == 0; })) continue;
    Spectrum spectrum;
    fft.fwd(spectrum, image[ring]);
    for (std::size_t f = 0; f < filters; ++f) {
      const Spectrum response = filtered(fft, spectrum, gains[f]);
      float& energy = d.q[ring * groups / rings * filters + f];
      for (std::size_t s = 0; s < sectors; ++s) {
        energy += std::norm(response[s]) / (sectors * rings_a_group);
        const int set = (response[s].real() > quiet ? 1 : 0) + (response[s].imag() > quiet ? 1 : 0);
        d.w[s * w_bins / sectors] += static_cast<float>(set * w_bins) / (2.0F * rings * filters * sectors);
      }
    }
  }
  for (float& energy : d.q) energy = std::sqrt(energy);
  return d;
}

}  // namespace headframe
