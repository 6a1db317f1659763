#include "server/place/descriptor_matches.hpp"

#include <algorithm>

namespace headframe {
namespace {

constexpr std::size_t neighbours = 5;  // of each keyframe, in the votes

float squared_distance(const std::vector<float>& p, const std::vector<float>& q) {
  float sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) sum += (p[i] - q[i]) * (p[i] - q[i]);
  return sum;
}

}  // namespace

std::vector<MatchedPair> match_descriptors(std::span<const Keyframe> a, std::span<const Keyframe> b) {
  std::vector<MatchedPair> matches;
  for (std::size_t j = 0; j < b.size(); ++j) {
    const auto& q = b[j].descriptor.q;
    if (q.empty()) continue;
    std::vector<MatchedPair> nearest;
    for (std::size_t i = 0; i < a.size(); ++i)
      if (a[i].descriptor.q.size() == q.size()) nearest.push_back({i, j, squared_distance(a[i].descriptor.q, q)});
    const std::size_t taken = std::min(neighbours, nearest.size());
    std::partial_sort(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(taken), nearest.end(),
                      [](const auto& m, const auto& n) {
                        return m.squared_distance < n.squared_distance ||
                               (m.squared_distance == n.squared_distance && m.a < n.a);
                      });
    matches.insert(matches.end(), nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(taken));
  }
  return matches;
}

}  // namespace headframe
