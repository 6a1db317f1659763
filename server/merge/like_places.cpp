#include "server/merge/like_places.hpp"

#include <algorithm>
#include <map>

#include "server/session/same_placement.hpp"
#include "server/verification/ramp.hpp"

namespace headframe {
namespace {

/// Path that says as much of an overlap as all that the mine shows elsewhere. With half of it the same placements are
/// accepted; with twice as much, four right ones of 356 fewer.
constexpr double mine_counts_m = 200;

/// How near to an overlap a place belongs to it: about as far as the descriptor of a keyframe describes. From 8 to 20 m
/// the same right placements of two mines are accepted (88 judged), but for one; with 35 m, as many as if all counted.
constexpr double overlap_reach_m = 12;

}  // namespace

std::vector<LikePlace> like_places(const std::vector<ScreeningResult>& screened, const std::set<std::size_t>& copies) {
  std::vector<LikePlace> out;
  std::vector<Pose> placements{Pose::Identity()};
  for (std::size_t i = 0; i < screened.size(); ++i) {
    const bool copy = copies.contains(i);
    const double as_copy = likeness(screened[i]), roughly = resemblance(screened[i]);
    if (!copy && as_copy <= 0 && roughly <= 0) continue;
    const Pose& T = screened[i].place.registration.T_target_source;
    const Eigen::Vector3d& p = screened[i].place.p_b;
    auto known = std::find_if(placements.begin(), placements.end(),
                              [&](const Pose& U) { return same_placement(T, U, p, same_look_alike); });
    if (known == placements.begin()) continue;
    if (known == placements.end()) known = placements.insert(known, T);
    out.push_back({p, T * p, static_cast<std::uint32_t>(known - placements.begin()), as_copy, roughly, copy});
  }
  return out;
}

void count_places(SelfLikeness& out) {
  std::map<std::uint32_t, LikePlace> best;  // by placement
  out.aliases = out.look_alikes = out.similar_places = 0;
  for (const LikePlace& place : out.places) {
    LikePlace& of_placement = best[place.placement];
    of_placement.likeness = std::max(of_placement.likeness, place.likeness);
    of_placement.resemblance = std::max(of_placement.resemblance, place.resemblance);
    out.aliases += place.copy ? 1 : 0;
  }
  for (const auto& [placement, place] : best) {
    out.look_alikes += place.likeness;
    out.similar_places += place.resemblance;
  }
}

SelfLikeness likeness_at(const SelfLikeness& likeness, std::span<const KeyframePosition> positions) {
  SelfLikeness out = likeness;
  if (out.places.empty() || positions.empty()) return out;
  std::erase_if(out.places, [&](const LikePlace& place) {
    const auto far = [&](const Eigen::Vector3d& p) { return nearest_to(positions, p).distance_m > overlap_reach_m; };
    return far(place.here) && far(place.there);
  });
  count_places(out);
  return out;
}

double searched_m(const SelfLikeness& likeness) { return likeness.wanted.empty() ? std::max(0.0, likeness.path_m) : 0; }

double expected_similar_places(double found, double path_m) {
  constexpr double where_unknown = 0.5;  // per 100 m
  const double missing_m = std::max(0.0, well_known_m - path_m);
  return per_100_m(found + where_unknown * missing_m / 100, path_m, well_known_m);
}

double expected_look_alikes(double of_mine, const SelfLikeness& a, const SelfLikeness& b, const Evidence& e) {
  const double found = of_mine * mine_counts_m / 100 + a.look_alikes + b.look_alikes;
  const double here = 100 * found / (mine_counts_m + searched_m(a) + searched_m(b));
  const double differ = ramp(e.descriptors_compared, 2, 4) * ramp(e.descriptors_alike, 0.76, 0.72);
  return here + differ * std::max(0.0, of_mine - here);
}

}  // namespace headframe
