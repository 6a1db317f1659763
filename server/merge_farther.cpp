// Where the mine is known to repeat itself, a placement that is about to be believed is looked at once more, as far as
// the lidars see: copies end somewhere.

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "server/merge_state.hpp"
#include "server/registration/parallel.hpp"

namespace headframe {
namespace {

constexpr double close_m = 5, step_m = 4;       // of b's path, where it passes so near to a's
constexpr std::size_t spots_unless_copies = 4;  // the ends of the overlap, and between

/// Free space alone: what a registration needs is kept small.
PlaceConfig farther() {
  PlaceConfig config;
  config.radius_m = 1;
  config.slack_m = 0;
  config.look_m = 25;
  config.look_leaf_m = 0.8F;
  config.view_reach_m = 35;
  return config;
}

/// The stand of a's nearest to p, if it is close.
const Stand* close_to(const std::vector<Stand>& a, const Eigen::Vector3d& p) {
  const auto distance = [&](const Stand& s) { return (s.p - p).norm(); };
  const auto nearest =
      std::min_element(a.begin(), a.end(), [&](const Stand& s, const Stand& t) { return distance(s) < distance(t); });
  return nearest == a.end() || distance(*nearest) > close_m ? nullptr : &*nearest;
}

/// Whether all clouds of the path within look_m of a keyframe are stored: of what is half known, far walls say nothing.
/// Those that can be had are wanted.
bool known_around(const Session& session, SessionId id, std::size_t keyframe, const CloudSource& clouds,
                  std::set<KeyframeRef>& wanted) {
  const double reach_m = farther().look_m, here_m = session.path_to_m[keyframe];
  bool known = true;
  for (std::size_t i = 0; i < session.keyframes.size(); ++i) {
    const Keyframe& k = session.keyframes[i];
    if (k.point_count == 0 || std::abs(session.path_to_m[i] - here_m) >= reach_m) continue;
    const CloudState state = clouds.state({id, k.sequence});
    known &= state == CloudState::stored;
    if (state == CloudState::obtainable) wanted.insert({id, k.sequence});
  }
  return known;
}

/// So many, evenly spread, the ends among them.
template <class T>
std::vector<T> spread_evenly(const std::vector<T>& all, std::size_t most) {
  if (all.size() <= most) return all;
  std::vector<T> out;
  for (std::size_t i = 0; i < most; ++i) out.push_back(all[i * (all.size() - 1) / (most - 1)]);
  return out;
}

}  // namespace

PlaceConfig MergePipeline::State::far_places_config() { return farther(); }

void MergePipeline::State::look_farther(const Laid& pair, const Case& c, Verdict& verdict, CloudSource& clouds) {
  Judgement& judgement = verdict.judgement;
  std::vector<std::pair<std::size_t, std::size_t>> spots;  // keyframes of a and b
  std::set<KeyframeRef> wanted;
  double next_m = std::numeric_limits<double>::lowest();
  for (const Stand& s : c.b.stored) {
    const double path_m = sessions.at(pair.b).path_to_m[s.keyframe];
    const Stand* other = close_to(c.a.stored, judgement.T_a_b * s.p);
    if (!other || path_m < next_m) continue;
    const bool known_a = known_around(sessions.at(pair.a), pair.a, other->keyframe, clouds, wanted),
               known_b = known_around(sessions.at(pair.b), pair.b, s.keyframe, clouds, wanted);
    if (!known_a || !known_b) continue;
    next_m = path_m + step_m;
    spots.emplace_back(other->keyframe, s.keyframe);
  }
  if (judgement.evidence.repetition < copies_known) spots = spread_evenly(spots, spots_unless_copies);
  std::vector<PlaceRequest> asked;
  for (const auto& [of_a, of_b] : spots) {
    asked.push_back(place_at(pair.a, of_a));
    asked.push_back(place_at(pair.b, of_b));
  }
  verdict.wanted.assign(wanted.begin(), wanted.end());
  const std::vector<PlacePtr> near = places.get(asked, clouds), far = far_places.get(asked, clouds);
  const JudgeConfig judge = judge_config();
  std::vector<double> violations(spots.size());
  for_blocks(spots.size(), 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
    const Place &of_a = *near[2 * i], &of_b = *near[2 * i + 1];
    PlaceCheck place = register_place(of_a, of_b, judgement.T_a_b, judge.place);
    const Pose& T = place.registration.T_target_source;
    const bool drifted = place.registration.status != RegistrationStatus::too_little_overlap &&
                         !differ(T, judgement.T_a_b, of_b.p, judge.place_drift_m, judge.place_drift_rad);
    look_at_place(place, *far[2 * i], *far[2 * i + 1], drifted ? T : judgement.T_a_b, farther());
    if (drifted) look_again(place, *far[2 * i], *far[2 * i + 1], judgement.T_a_b, farther());
    violations[i] = place.between().violation();
  });
  double& worst = judgement.evidence.farther_violation;
  for (const double violation : violations) worst = std::max(worst, violation);
}

}  // namespace headframe
