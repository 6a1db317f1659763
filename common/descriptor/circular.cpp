#include "common/descriptor/circular.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace headframe {

std::vector<YawScore> correlate_circular(const std::vector<float>& w_a, const std::vector<float>& w_b,
                                         std::size_t most) {
  const std::size_t n = w_a.size();
  if (n == 0 || w_b.size() != n) return {};
  const auto centred = [n](const std::vector<float>& w) {
    const double mean = std::accumulate(w.begin(), w.end(), 0.0) / static_cast<double>(n);
    std::vector<double> c(w.begin(), w.end());
    double norm = 0;
    for (double& v : c) {
      v -= mean;
      norm += v * v;
    }
    for (double& v : c) v /= std::sqrt(norm) + 1e-12;
    return c;
  };
  const auto a = centred(w_a), b = centred(w_b);
  std::vector<double> score(n);
  for (std::size_t shift = 0; shift < n; ++shift)
    for (std::size_t i = 0; i < n; ++i) score[shift] += a[(i + shift) % n] * b[i];

  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](auto i, auto j) { return score[i] > score[j]; });
  const double step = 2 * std::numbers::pi / static_cast<double>(n);
  constexpr double apart_rad = 20 * std::numbers::pi / 180;
  std::vector<YawScore> peaks;
  for (std::size_t i : order) {
    if (peaks.size() == most) break;
    // A parabola through the peak and its neighbours gives the yaw below one step.
    const double left = score[(i + n - 1) % n], right = score[(i + 1) % n];
    const double bend = left - 2 * score[i] + right;
    const double offset = bend < 0 ? std::clamp(0.5 * (left - right) / bend, -0.5, 0.5) : 0;
    double yaw = (static_cast<double>(i) + offset) * step;
    if (yaw > std::numbers::pi) yaw -= 2 * std::numbers::pi;
    const bool taken = std::any_of(peaks.begin(), peaks.end(), [&](const YawScore& p) {
      return std::abs(std::remainder(p.yaw_rad - yaw, 2 * std::numbers::pi)) < apart_rad;
    });
    if (!taken) peaks.push_back({yaw, score[i]});
  }
  return peaks;
}

}  // namespace headframe
