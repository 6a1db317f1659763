#include "server/place/descriptor_matches.hpp"

#include <algorithm>

#include "server/place/descriptor_index.hpp"

namespace headframe {
namespace {

constexpr std::size_t neighbours = 5;  // of each keyframe, in the votes

}  // namespace

std::vector<MatchedPair> match_descriptors(std::span<const Keyframe> a, std::span<const Keyframe> b, int threads) {
  const auto first = std::find_if(a.begin(), a.end(), [](const Keyframe& k) { return !k.descriptor.q.empty(); });
  if (first == a.end()) return {};
  const std::size_t q_size = first->descriptor.q.size();
  const auto index = make_exact_index(q_size);
  for (std::size_t i = 0; i < a.size(); ++i)
    if (const auto& q = a[i].descriptor.q; q.size() == q_size) index->add({0, i}, q);
  std::vector<std::span<const float>> asked;
  std::vector<std::size_t> asked_by;
  for (std::size_t j = 0; j < b.size(); ++j) {
    if (b[j].descriptor.q.size() != q_size) continue;
    asked.emplace_back(b[j].descriptor.q);
    asked_by.push_back(j);
  }
  const auto answers = index->nearest_of_each(asked, neighbours, threads);
  std::vector<MatchedPair> matches;
  matches.reserve(neighbours * answers.size());
  for (std::size_t k = 0; k < answers.size(); ++k)
    for (const PlaceNeighbour& n : answers[k])
      matches.push_back({static_cast<std::size_t>(n.keyframe.sequence), asked_by[k], n.squared_distance});
  return matches;
}

}  // namespace headframe
