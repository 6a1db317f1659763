#include "server/operator/thin_path.hpp"

#include <algorithm>
#include <utility>

namespace headframe {
namespace {

constexpr std::size_t most_together = 512;  // keyframes per section, because a crooked section takes quadratic time

/// The position on the line from `from` to `to` at the sequence number of `at`.
Eigen::Vector3d stand_in(const Keyframe& from, const Keyframe& to, const Keyframe& at) {
  const double share =
      static_cast<double>(at.sequence - from.sequence) / static_cast<double>(to.sequence - from.sequence);
  return (1 - share) * position(from) + share * position(to);
}

/// The Douglas-Peucker algorithm, but compares with the position at the same sequence number instead of the nearest
/// point of the line.
void mark(const std::vector<Keyframe>& path, std::size_t first, std::size_t last, double tolerance_m,
          std::vector<bool>& stays) {
  std::vector<std::pair<std::size_t, std::size_t>> lines{{first, last}};
  while (!lines.empty()) {
    const auto [from, to] = lines.back();
    lines.pop_back();
    std::size_t farthest = from;
    double off_m = tolerance_m;
    for (std::size_t i = from + 1; i < to; ++i) {
      const double m = (position(path[i]) - stand_in(path[from], path[to], path[i])).norm();
      if (!(m <= off_m)) off_m = m, farthest = i;
    }
    if (farthest == from) continue;
    stays[farthest] = true;
    lines.emplace_back(from, farthest);
    lines.emplace_back(farthest, to);
  }
}

}  // namespace

std::vector<Keyframe> thin_path(std::vector<Keyframe> path, double tolerance_m) {
  if (tolerance_m <= 0 || path.size() < 3) return path;
  std::vector<bool> stays(path.size(), false);
  stays.front() = true;
  for (std::size_t first = 0; first + 1 < path.size(); first += most_together) {
    const std::size_t last = std::min(first + most_together, path.size() - 1);
    stays[last] = true;
    mark(path, first, last, tolerance_m, stays);
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < path.size(); ++i)
    if (stays[i]) {
      if (kept != i) path[kept] = std::move(path[i]);
      ++kept;
    }
  path.resize(kept);
  return path;
}

}  // namespace headframe
