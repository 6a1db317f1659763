#include "server/merge/self_similarity.hpp"

#include <algorithm>

#include "server/merge/like_places.hpp"
#include "server/session/same_placement.hpp"

namespace headframe {
namespace {

// Limit of the score of a placement of a session on itself, relative to that of the identity. In drawn mines 30 of 35
// copies have more, and in those with junctions, rooms or ramps 23 of 196 other placements; in grids, smooth tunnels
// and mines of copies more do.
constexpr double alike_walls = 0.2;

/// Least length of a copy: a single place fits at many others in any mine, but the next place along the path does not.
constexpr double copy_m = 15;

std::size_t keyframe_nearest(std::span<const Keyframe> keyframes, const Eigen::Vector3d& p) {
  const auto far = [&](const Keyframe& k) { return (k.T_local_sensor.translation() - p).squaredNorm(); };
  const auto nearest = std::min_element(keyframes.begin(), keyframes.end(),
                                        [&](const Keyframe& k, const Keyframe& l) { return far(k) < far(l); });
  return static_cast<std::size_t>(nearest - keyframes.begin());
}

/// The keyframe at which the path has this length; nullopt if it is shorter.
std::optional<std::size_t> keyframe_at(std::span<const double> path_to_m, double path_m) {
  const auto at = std::lower_bound(path_to_m.begin(), path_to_m.end(), path_m);
  if (path_m < 0 || at == path_to_m.end()) return std::nullopt;
  return static_cast<std::size_t>(at - path_to_m.begin());
}

std::size_t count_clouds(const Session& session, SessionId id, const CloudSource& clouds, CloudState state) {
  return static_cast<std::size_t>(std::count_if(session.keyframes.begin(), session.keyframes.end(), [&](const auto& k) {
    return clouds.state({id, k.sequence}) == state;
  }));
}

}  // namespace

bool SelfSimilarity::known(SessionId id, const CloudSource& clouds) const {
  // A complete session's end is always included; otherwise the result would depend on when of() was last called.
  const Session& session = sessions_.at(id);
  const bool all_here = session.complete && count_clouds(session, id, clouds, CloudState::obtainable) == 0;
  const double growth = session.complete ? 1 : 1.25, clouds_growth = all_here ? 1 : 1.25;
  const SelfLikeness& known = last(id);
  const bool answered =
      !known.wanted.empty() && std::none_of(known.wanted.begin(), known.wanted.end(),
                                            [&](const auto& k) { return clouds.state(k) == CloudState::obtainable; });
  return known.path_m >= 0 && !answered && session.path_m() <= growth * known.path_m &&
         static_cast<double>(count_clouds(session, id, clouds, CloudState::stored)) <=
             clouds_growth * static_cast<double>(known.clouds);
}

const SelfLikeness& SelfSimilarity::last(SessionId id) const {
  static const SelfLikeness nothing;
  const auto found = known_.find(id);
  return found == known_.end() ? nothing : found->second;
}

const SelfLikeness& SelfSimilarity::of(SessionId id, CloudSource& clouds) {
  if (known(id, clouds)) return known_.at(id);
  auto found = known_elsewhere_ ? known_elsewhere_(id, clouds) : std::nullopt;
  if (!found) found = search(id, clouds);
  news_[id] = *found;
  return known_[id] = std::move(*found);
}

SelfLikeness SelfSimilarity::search(SessionId id, CloudSource& clouds) {
  const Session& session = sessions_.at(id);
  const Found* found = finder_.find_within({id, session.keyframes});
  std::vector<Case> cases;
  double itself = 0;
  for (const Hypothesis& h : found->hypotheses)
    if (same_placement(h.T_a_b, Pose::Identity(), h.place_b, same_as_itself))
      itself = std::max(itself, h.score);
    else
      cases.push_back(requests_.make_case(id, id, h, clouds));
  std::vector<KeyframeRef> wanted;
  for (const Case& c : cases)
    if (c.hypothesis.score >= alike_walls * itself) {
      std::vector<Case> asked = beside(id, c.hypothesis, clouds);
      asked.push_back(c);
      for (const Case& one : asked) {
        const auto more = requests_.clouds_for_screening({id, id}, one);
        wanted.insert(wanted.end(), more.begin(), more.end());
      }
    }
  const std::vector<ScreeningResult> screened = screen({id, id}, cases, submaps_, clouds, judge_);
  SelfLikeness out;
  out.path_m = session.path_m();
  out.clouds = count_clouds(session, id, clouds, CloudState::stored);
  out.places = like_places(screened, copies_within(id, screened, clouds));
  count_places(out);
  out.wanted = std::move(wanted);
  return out;
}

std::vector<Case> SelfSimilarity::beside(SessionId id, const Hypothesis& hypothesis, const CloudSource& clouds) const {
  const Session& session = sessions_.at(id);
  const std::size_t here = keyframe_nearest(session.keyframes, hypothesis.place_b);
  std::vector<Case> out;
  for (const double way : {-copy_m, copy_m})
    if (const auto there = keyframe_at(session.path_to_m, session.path_to_m[here] + way)) {
      Hypothesis next = hypothesis;
      next.place_b = session.keyframes[*there].T_local_sensor.translation();
      out.push_back(requests_.make_case(id, id, next, clouds));
    }
  return out;
}

std::set<std::size_t> SelfSimilarity::copies_within(SessionId id, const std::vector<ScreeningResult>& screened,
                                                    CloudSource& clouds) {
  std::vector<Case> neighbours;  // of the placements that fit
  std::vector<std::size_t> of;
  for (std::size_t i = 0; i < screened.size(); ++i) {
    const Pose& T = screened[i].place.registration.T_target_source;
    const Eigen::Vector3d& p = screened[i].place.p_b;
    if (!fits_alone(screened[i]) || same_placement(T, Pose::Identity(), p, same_as_itself)) continue;
    for (Case& next : beside(id, {T, 0, p}, clouds)) {
      neighbours.push_back(std::move(next));
      of.push_back(i);
    }
  }
  const std::vector<ScreeningResult> next = screen({id, id}, neighbours, submaps_, clouds, judge_);
  std::set<std::size_t> copies;
  for (std::size_t k = 0; k < next.size(); ++k) {
    const bool apart = (next[k].place.p_b - screened[of[k]].place.p_b).norm() > copy_m / 2;
    const bool same = same_placement(next[k].place.registration.T_target_source, neighbours[k].hypothesis.T_a_b,
                                     next[k].place.p_b, same_registration);
    if (apart && same && fits_alone(next[k])) copies.insert(of[k]);
  }
  return copies;
}

void SelfSimilarity::tell_of_mine(Evidence& evidence) const {
  const OfMine all = of_mine();
  evidence.repetition = per_100_m(all.aliases, all.searched_m, 500);
  evidence.mine_look_alikes = per_100_m(all.look_alikes, all.searched_m, 200);
  evidence.mine_similar_places =
      std::max(evidence.mine_similar_places, expected_similar_places(all.similar_places, all.searched_m));
}

SelfSimilarity::OfMine SelfSimilarity::of_mine() const {
  OfMine all;
  for (const auto& [id, found] : known_) {
    all.aliases += found.aliases;
    all.look_alikes += found.look_alikes;
    all.similar_places += found.similar_places;
    all.searched_m += searched_m(found);
  }
  return all;
}

}  // namespace headframe
