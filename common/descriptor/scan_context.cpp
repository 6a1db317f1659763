#include "common/descriptor/scan_context.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace headframe {
namespace {

constexpr std::size_t rings = 20;
constexpr std::size_t sectors = 60;
constexpr float reach_m = 40.0F;
constexpr std::size_t fewest_points = 50;

struct Cell {
  float low = 0;
  float high = 0;
  bool seen = false;
  float height() const { return seen ? high - low : 0; }
};
using Grid = std::array<std::array<Cell, sectors>, rings>;

Grid draw(const Points& points) {
  Grid grid;
  for (const auto& p : points) {
    const float r = std::hypot(p.x(), p.y());
    if (r >= reach_m) continue;
    const auto ring = static_cast<std::size_t>(std::sqrt(r / reach_m) * rings);
    const float turn = std::atan2(p.y(), p.x()) / (2 * std::numbers::pi_v<float>);
    const auto sector = static_cast<std::size_t>((turn < 0 ? turn + 1 : turn) * sectors) % sectors;
    Cell& cell = grid[std::min(ring, rings - 1)][sector];
    cell.low = cell.seen ? std::min(cell.low, p.z()) : p.z();
    cell.high = cell.seen ? std::max(cell.high, p.z()) : p.z();
    cell.seen = true;
  }
  return grid;
}

}  // namespace

Result<Descriptor> ScanContext::extract(const Points& points_level) const {
  if (points_level.size() < fewest_points)
    return failure(ErrorCode::bad_input, "scan of " + std::to_string(points_level.size()) +
                                             " usable points, at least " + std::to_string(fewest_points) +
                                             " are needed for a descriptor");
  const Grid grid = draw(points_level);
  Descriptor d;
  d.w.assign(sectors, 0);
  for (const auto& ring : grid) {
    float seen = 0, sum = 0, squares = 0;
    for (std::size_t s = 0; s < sectors; ++s) {
      const float h = ring[s].height();
      seen += ring[s].seen ? 1.0F : 0.0F;
      sum += h;
      squares += h * h;
      d.w[s] += h / rings;
    }
    const float mean = sum / sectors;
    d.q.push_back(mean);
    d.q.push_back(std::sqrt(std::max(0.0F, squares / sectors - mean * mean)));
    d.q.push_back(seen / sectors);
  }
  return d;
}

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

std::vector<YawScore> ScanContext::yaw_difference(const std::vector<float>& w_a, const std::vector<float>& w_b,
                                                  std::size_t most) const {
  return correlate_circular(w_a, w_b, most);
}

}  // namespace headframe
