// Copies that a mine shows of itself: a session is laid on itself elsewhere, and what fits there for 15 m and more
// counts.

#include <algorithm>
#include <set>

#include "server/merge_state.hpp"

namespace headframe {
namespace {

// Score of a placement of a session on itself, over that of where it lies: in drawn mines 30 of 35 copies have more,
// and of the others 23 of 196 where there are junctions, rooms or ramps; more in grids, smooth drifts and mines of
// copies.
constexpr double alike_walls = 0.2;
constexpr double elsewhere_m = 6, elsewhere_rad = 0.5;  // a session turned or moved less lies where it is

/// A copy has to be so long: one place fits at many others in any mine, and the next place along the path does not.
constexpr double copy_m = 15;

std::size_t keyframe_nearest(std::span<const Keyframe> keyframes, const Eigen::Vector3d& p) {
  const auto far = [&](const Keyframe& k) { return (k.T_local_sensor.translation() - p).squaredNorm(); };
  const auto nearest = std::min_element(keyframes.begin(), keyframes.end(),
                                        [&](const Keyframe& k, const Keyframe& l) { return far(k) < far(l); });
  return static_cast<std::size_t>(nearest - keyframes.begin());
}

/// The keyframe at which the path has this length; none: it is not so long.
std::optional<std::size_t> keyframe_at(std::span<const double> path_to_m, double path_m) {
  const auto at = std::lower_bound(path_to_m.begin(), path_to_m.end(), path_m);
  if (path_m < 0 || at == path_to_m.end()) return std::nullopt;
  return static_cast<std::size_t>(at - path_to_m.begin());
}

std::size_t stored_clouds(const Session& session, SessionId id, const CloudSource& clouds) {
  return static_cast<std::size_t>(std::count_if(session.keyframes.begin(), session.keyframes.end(), [&](const auto& k) {
    return clouds.state({id, k.sequence}) == CloudState::stored;
  }));
}

}  // namespace

bool MergePipeline::State::self_likeness_known(SessionId id, const CloudSource& clouds) const {
  // The end of a session that is complete counts too, or what is found would hang on when it was asked last.
  const double growth = sessions.at(id).complete ? 1 : 1.25, clouds_growth = 1.25;
  const SelfLikeness& known = sessions.at(id).self;
  const bool answered =
      !known.wanted.empty() && std::none_of(known.wanted.begin(), known.wanted.end(),
                                            [&](const auto& k) { return clouds.state(k) == CloudState::obtainable; });
  return known.path_m >= 0 && !answered && sessions.at(id).path_m() <= growth * known.path_m &&
         static_cast<double>(stored_clouds(sessions.at(id), id, clouds)) <=
             clouds_growth * static_cast<double>(known.clouds);
}

double look_alikes(std::vector<Glance> glances, const Pose& T) {
  constexpr double other_m = 4, other_rad = 0.3;
  std::stable_sort(glances.begin(), glances.end(),
                   [](const Glance& g, const Glance& h) { return likeness(g) > likeness(h); });
  std::vector<Pose> counted{T};
  double sum = 0;
  for (const Glance& g : glances) {
    const double alike = likeness(g);
    if (alike <= 0) break;
    const Pose& here = g.place.registration.T_target_source;
    const auto near = [&](const Pose& U) { return !differ(here, U, g.place.p_b, other_m, other_rad); };
    if (std::any_of(counted.begin(), counted.end(), near)) continue;
    counted.push_back(here);
    sum += alike;
  }
  return sum;
}

double MergePipeline::State::self_aliases(SessionId id, CloudSource& clouds) {
  Session& session = sessions[id];
  if (self_likeness_known(id, clouds)) return session.self.aliases;
  const Found* found = finder.find_within({id, session.keyframes});
  std::vector<Case> cases;
  double itself = 0;
  for (const Hypothesis& h : found->hypotheses)
    if (differ(h.T_a_b, Pose::Identity(), h.place_b, elsewhere_m, elsewhere_rad))
      cases.push_back(make_case(id, id, h, clouds));
    else
      itself = std::max(itself, h.score);
  std::vector<KeyframeRef> wanted;
  for (const Case& c : cases)
    if (c.hypothesis.score >= alike_walls * itself) {
      std::vector<Case> asked = beside(id, c.hypothesis, clouds);
      asked.push_back(c);
      for (const Case& one : asked) {
        const auto more = wanted_to_look({id, id}, one);
        wanted.insert(wanted.end(), more.begin(), more.end());
      }
    }
  const std::vector<Glance> glances = glance_at(id, id, cases, clouds);
  session.self = {.path_m = session.path_m(),
                  .clouds = stored_clouds(session, id, clouds),
                  .aliases = static_cast<double>(copies_within(id, glances, clouds)),
                  .look_alikes = look_alikes(glances, Pose::Identity()),
                  .wanted = std::move(wanted)};
  return session.self.aliases;
}

std::vector<Case> MergePipeline::State::beside(SessionId id, const Hypothesis& hypothesis, const CloudSource& clouds) {
  const Session& session = sessions.at(id);
  const std::size_t here = keyframe_nearest(session.keyframes, hypothesis.place_b);
  std::vector<Case> out;
  for (const double way : {-copy_m, copy_m})
    if (const auto there = keyframe_at(session.path_to_m, session.path_to_m[here] + way)) {
      Hypothesis next = hypothesis;
      next.place_b = session.keyframes[*there].T_local_sensor.translation();
      out.push_back(make_case(id, id, next, clouds));
    }
  return out;
}

int MergePipeline::State::copies_within(SessionId id, const std::vector<Glance>& glances, CloudSource& clouds) {
  std::vector<Case> neighbours;  // of those that fit
  std::vector<std::size_t> of;
  for (std::size_t i = 0; i < glances.size(); ++i) {
    const Pose& T = glances[i].place.registration.T_target_source;
    const Eigen::Vector3d& p = glances[i].place.p_b;
    if (!fits_alone(glances[i]) || !differ(T, Pose::Identity(), p, elsewhere_m, elsewhere_rad)) continue;
    for (Case& next : beside(id, {T, 0, p}, clouds)) {
      neighbours.push_back(std::move(next));
      of.push_back(i);
    }
  }
  const std::vector<Glance> next = glance_at(id, id, neighbours, clouds);
  std::set<std::size_t> copies;
  for (std::size_t k = 0; k < next.size(); ++k) {
    const bool apart = (next[k].place.p_b - glances[of[k]].place.p_b).norm() > copy_m / 2;
    const bool same = !differ(next[k].place.registration.T_target_source, neighbours[k].hypothesis.T_a_b,
                              next[k].place.p_b, same_placement_m, same_placement_rad);
    if (apart && same && fits_alone(next[k])) copies.insert(of[k]);
  }
  return static_cast<int>(copies.size());
}

double MergePipeline::State::repetition() const {
  constexpr double least_m = 500;
  double copies = 0, path_m = 0;
  for (const auto& [id, session] : sessions) {
    copies += session.self.aliases;
    if (session.self.wanted.empty()) path_m += std::max(0.0, session.self.path_m);
  }
  return 100 * copies / std::max(path_m, least_m);
}

}  // namespace headframe
