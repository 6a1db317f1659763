#include "server/atlas/support.hpp"

#include <cmath>
#include <map>
#include <numbers>
#include <queue>
#include <tuple>
#include <utility>

namespace headframe {
namespace {

using Merges = std::multimap<SessionId, const Alignment*>;  // by either of their sessions

/// Goes out from the anchor, over the surest merge first.
class Way {
 public:
  Way(SessionId anchor, const Merges& merges) : merges_(merges) {
    PlacementSupport first;
    first.session = anchor;
    reach(first);
    while (!ahead_.empty()) {
      const auto [sure, id, merge, to] = ahead_.top();
      ahead_.pop();
      if (!reached_.contains(to)) reach(behind(*merge, to));
    }
  }

  /// Sorted by session.
  std::vector<PlacementSupport> supports() const {
    std::vector<PlacementSupport> out;
    out.reserve(reached_.size());
    for (const auto& [session, support] : reached_) out.push_back(support);
    return out;
  }

 private:
  PlacementSupport behind(const Alignment& merge, SessionId session) const {
    const Evidence& e = merge.evidence;
    const MergeDeviation own = deviation_of(e);
    PlacementSupport support = reached_.at(merge.a == session ? merge.b : merge.a);
    support.merged_with = std::exchange(support.session, session);
    support.probability = std::min(support.probability, e.probability);
    support.shared_m = e.overlap_m;
    support.confirmed = merge.ruling == Ruling::confirmed;
    support.deviation_m = std::hypot(support.deviation_m, own.metres);
    support.deviation_rad = std::hypot(support.deviation_rad, own.radians);
    return support;
  }

  void reach(PlacementSupport support) {
    const auto [begin, end] = merges_.equal_range(support.session);
    support.merges = static_cast<int>(std::distance(begin, end));
    reached_[support.session] = support;
    for (auto it = begin; it != end; ++it) {
      const Alignment& merge = *it->second;
      const double sure = std::min(support.probability, merge.evidence.probability);
      ahead_.emplace(sure, -merge.id, &merge, merge.a == support.session ? merge.b : merge.a);
    }
  }

  const Merges& merges_;
  std::map<SessionId, PlacementSupport> reached_;
  std::priority_queue<std::tuple<double, AlignmentId, const Alignment*, SessionId>>
      ahead_;  // of equals the older first
};

}  // namespace

MergeDeviation deviation_of(const Evidence& e) {
  constexpr double least_m = 0.1, least_rad = 0.3 * std::numbers::pi / 180, least_lever_m = 10;
  return {std::hypot(least_m, e.spread_m), std::hypot(least_rad, e.spread_m / std::max(e.overlap_m, least_lever_m))};
}

void add_supports(Atlas& atlas, std::span<const Alignment> alignments) {
  Merges merges;
  for (const Alignment& alignment : alignments) {
    if (alignment.state != AlignmentState::published) continue;
    merges.emplace(alignment.a, &alignment);
    merges.emplace(alignment.b, &alignment);
  }
  for (Component& component : atlas.components) {
    component.supports.clear();
    if (component.placements.size() > 1) component.supports = Way(component.id, merges).supports();
  }
}

}  // namespace headframe
