#include "common/descriptor/open_sky.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/descriptor/lidar_iris.hpp"
#include "common/descriptor/scan_context.hpp"

namespace headframe {
namespace {

// Measured: 0 underground, even with a field of view of 20 deg tilted by 10 deg; on a campus .08 or more in 19 of 20
// scans.
constexpr double closed_share = 0.02, open_share = 0.06;

// From a campus: scales that make the median difference between two places as large as that of the network's q.
constexpr float heights_scale = 0.09F, energies_scale = 5.7F;

constexpr std::size_t context_rings = 20,
                      of_a_ring = 3;  // of Scan Context's q: mean and spread of the heights, share seen
constexpr std::size_t iris_groups = 20, of_a_group = 4;  // of LiDAR-Iris' q: energies behind four filters

/// A signature resampled to another length, linearly between the middles of the sectors.
std::vector<float> resampled(const std::vector<float>& w, std::size_t length) {
  std::vector<float> out(length);
  for (std::size_t s = 0; s < length; ++s) {
    const double at =
        (static_cast<double>(s) + 0.5) * static_cast<double>(w.size()) / static_cast<double>(length) - 0.5;
    const double before = std::floor(at);
    const auto share = static_cast<float>(at - before);
    const std::size_t i = (static_cast<std::size_t>(before + static_cast<double>(w.size()))) % w.size();
    out[s] = (1 - share) * w[i] + share * w[(i + 1) % w.size()];
  }
  return out;
}

/// Normalised to mean zero and length one, as signatures are compared.
std::vector<float> centred(std::vector<float> w) {
  const float mean = std::accumulate(w.begin(), w.end(), 0.0F) / static_cast<float>(w.size());
  float squares = 1e-12F;
  for (float& v : w) {
    v -= mean;
    squares += v * v;
  }
  for (float& v : w) v /= std::sqrt(squares);
  return w;
}

}  // namespace

double openness(const RangeImage& image) {
  const std::size_t above = image.spec.rows / 2, half = image.spec.columns / 2;
  const auto is_empty = [&](std::size_t column) {
    std::size_t seen = 0;
    for (std::size_t r = 0; r < above; ++r) seen += image.at(r, column) > 0 ? 1 : 0;
    return 2 * seen < above;
  };
  std::size_t empty = 0;
  for (std::size_t c = 0; c < half; ++c) empty += is_empty(c) && is_empty(c + half) ? 1 : 0;
  const double share = static_cast<double>(empty) / static_cast<double>(half);
  return std::clamp((share - closed_share) / (open_share - closed_share), 0.0, 1.0);
}

Result<void> add_open_sky(Descriptor& descriptor, const Points& points_level, double open) {
  const std::size_t begin = descriptor.q.size();
  descriptor.q.resize(begin + open_sky_q_size, 0);
  if (open <= 0) return {};
  const auto heights = ScanContext().extract(points_level);
  if (!heights) return tl::unexpected(heights.error());
  const auto energies = LidarIris().extract(points_level);
  if (!energies) return tl::unexpected(energies.error());
  const auto share = static_cast<float>(open);
  auto added = descriptor.q.begin() + static_cast<std::ptrdiff_t>(begin);
  for (std::size_t i = 0; i < context_rings; ++i)
    for (std::size_t k = 0; k < 2; ++k) *added++ = share * heights_scale * heights->q[of_a_ring * i + k];
  for (std::size_t i = 0; i < iris_groups; i += 2)
    for (std::size_t k = 0; k < of_a_group; k += 2) {
      const float both = energies->q[of_a_group * i + k] + energies->q[of_a_group * (i + 1) + k];
      *added++ = share * energies_scale * both / 2;
    }
  const auto of_network = centred(descriptor.w), of_heights = centred(resampled(heights->w, descriptor.w.size()));
  for (std::size_t s = 0; s < descriptor.w.size(); ++s)
    descriptor.w[s] = (1 - share) * of_network[s] + share * of_heights[s];
  return {};
}

}  // namespace headframe
