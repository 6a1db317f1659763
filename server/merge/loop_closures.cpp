#include "server/merge/loop_closures.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/merge/alignment_edges.hpp"
#include "server/session/same_placement.hpp"
#include "server/support/stopwatch.hpp"
#include "server/verification/place_fit.hpp"
#include "server/verification/submap_check.hpp"

namespace headframe {

/// Searches from known places outwards, because a closure at one place predicts the next.
class LoopClosures::Search {
 public:
  Search(const LoopClosures& of, const Pair& pair, const Known& known, CloudSource& clouds)
      : of_(of),
        pair_(pair),
        known_(known),
        clouds_(clouds),
        a_(of.sessions_.at(pair.first)),
        b_(of.sessions_.at(pair.second)) {
    for (std::size_t k = 0; k < b_.keyframes.size(); ++k)
      if (place_of(k)) meet_.push_back(k);
  }

  std::optional<Place> next() const {
    std::optional<Place> best;
    double least_m = std::numeric_limits<double>::max();
    for (const std::size_t k : meet_) {
      if (known_.tried.contains(of_.piece_of(b_, k))) continue;
      const double m = from_known_m(k);
      if (m >= least_m) continue;
      const auto place = place_of(k);
      if (!place || !ready(place->in_a, pair_.first, a_) || !ready(place->in_b, pair_.second, b_)) continue;
      least_m = m;
      best = place;
    }
    return best;
  }

 private:
  bool within_itself() const { return pair_.first == pair_.second; }

  /// Distance along b's path from the nearest known closure, or without any from the middle of the overlap.
  double from_known_m(std::size_t keyframe) const {
    if (known_.places.empty()) return std::abs(b_.path_to_m[keyframe] - b_.path_to_m[meet_[meet_.size() / 2]]);
    return std::abs(b_.path_to_m[keyframe] - b_.path_to_m[nearest_known(keyframe)->to.sequence - 1]);
  }

  const PoseConstraint* nearest_known(std::size_t keyframe) const {
    const PoseConstraint* nearest = nullptr;
    double least_m = std::numeric_limits<double>::max();
    for (const auto& [piece, place] : known_.places)
      if (const double m = std::abs(b_.path_to_m[place.to.sequence - 1] - b_.path_to_m[keyframe]); m < least_m)
        least_m = m, nearest = &place;
    return nearest;
  }

  Pose T_a_b_near(std::size_t keyframe) const {
    if (within_itself()) return Pose::Identity();
    const PoseConstraint* known = nearest_known(keyframe);
    return known ? session_transform(*known, a_, b_) : known_.T_a_b;
  }

  /// b's keyframe with the nearest keyframe of a, or of an earlier visit of the same session; nullopt: they do not meet
  /// here.
  std::optional<Place> place_of(std::size_t k) const {
    Place out{0, k, T_a_b_near(k), of_.rules_.most_moved_m};
    const Eigen::Vector3d p = out.T_a_b * b_.keyframes[k].T_local_sensor.translation();
    std::optional<double> nearest_m;
    for (std::size_t i = 0; i < (within_itself() ? k : a_.keyframes.size()); ++i) {
      double near_m = of_.rules_.farthest_m;
      if (within_itself()) {
        const double between_m = b_.path_to_m[k] - b_.path_to_m[i];
        if (between_m < of_.rules_.apart_m) break;
        near_m = std::min(near_m, of_.rules_.near_m + of_.rules_.drift * between_m);
      }
      const double m = (a_.keyframes[i].T_local_sensor.translation() - p).norm();
      if (m > near_m || (nearest_m && m >= *nearest_m)) continue;
      nearest_m = m;
      out.in_a = i;
      if (within_itself()) out.most_moved_m = near_m;
    }
    return nearest_m ? std::optional(out) : std::nullopt;
  }

  /// Whether its cloud is stored and the robot has left the stretch that the submap will cover.
  bool ready(std::size_t keyframe, SessionId id, const Session& session) const {
    return (session.complete || session.path_to_m[keyframe] + JudgeConfig{}.place.window_m <= session.path_m()) &&
           clouds_.state({id, session.keyframes[keyframe].sequence}) == CloudState::stored;
  }

  const LoopClosures& of_;
  const Pair pair_;
  const Known& known_;
  CloudSource& clouds_;
  const Session &a_, &b_;
  std::vector<std::size_t> meet_;  // keyframes of b
};

std::vector<PairClosures> LoopClosures::find(SessionId id, std::span<const Alignment> alignments,
                                             const Attempt& attempt) {
  const Stopwatch watch(attempt.report.times.loop_closures_ms);
  std::vector<PairClosures> news;
  std::size_t left = rules_.at_once;
  const auto look = [&](const Pair& pair, const Pose& T_a_b) {
    if (sessions_.at(pair.first).keyframes.empty() || sessions_.at(pair.second).keyframes.empty()) return;
    Known& known = known_[pair];
    const Eigen::Vector3d p = sessions_.at(pair.second).middle();
    if (!same_placement(known.T_a_b, T_a_b, p, same_as_rival)) known = {};
    known.T_a_b = T_a_b;
    const Search search(*this, pair, known, attempt.clouds);
    const std::size_t before = known.places.size();
    for (auto place = search.next(); place; place = search.next()) {
      if (left == 0) {
        attempt.report.unfinished = true;
        break;
      }
      --left;
      attempt.clouds.working_on(pair.first, pair.second);
      const int piece = piece_of(sessions_.at(pair.second), place->in_b);
      known.tried.insert(piece);
      if (const auto found = registered(pair, *place, attempt.clouds)) known.places[piece] = *found;
    }
    if (known.places.size() == before) return;
    std::vector<PoseConstraint> all;
    for (const auto& [piece, constraint] : known.places) all.push_back(constraint);
    news.push_back({pair.first, pair.second, std::make_shared<const std::vector<PoseConstraint>>(std::move(all))});
  };
  look({id, id}, Pose::Identity());
  for (const Alignment& k : alignments)
    if (k.state == AlignmentState::published && (k.a == id || k.b == id) && sessions_.contains(k.a) &&
        sessions_.contains(k.b))
      look({k.a, k.b}, k.T_a_b);
  return news;
}

void LoopClosures::restore(const PairClosures& stored) {
  const Session &a = sessions_.at(stored.a), &b = sessions_.at(stored.b);
  Known& known = known_[{stored.a, stored.b}];
  for (const PoseConstraint& place : known_closures(stored.places, a, b)) {
    const int piece = piece_of(b, place.to.sequence - 1);
    known.tried.insert(piece);
    known.places[piece] = place;
    if (stored.a != stored.b) known.T_a_b = session_transform(place, a, b);
  }
}

void LoopClosures::forget(SessionId session) {
  std::erase_if(known_, [&](const auto& k) { return k.first.first == session || k.first.second == session; });
}

int LoopClosures::piece_of(const Session& session, std::size_t keyframe) const {
  return static_cast<int>(session.path_to_m[keyframe] / rules_.every_m);
}

std::optional<PoseConstraint> LoopClosures::registered(const Pair& pair, const Place& place, CloudSource& clouds) {
  const auto [id_a, id_b] = pair;
  const std::array asked{submaps_.at(id_a, place.in_a), submaps_.at(id_b, place.in_b)};
  const std::vector<SubmapPtr> submaps = submaps_.near(asked, clouds);
  const Submap &a = *submaps[0], &b = *submaps[1];
  const SubmapConfig config = JudgeConfig{}.place;
  if (a.source.points.empty() || b.source.points.empty()) return std::nullopt;
  SubmapCheck check = register_submaps(a, b, place.T_a_b, config);
  const Registration& r = check.registration;
  if (r.status != RegistrationStatus::converged && r.status != RegistrationStatus::degenerate) return std::nullopt;
  if (!same_placement(r.T_target_source, place.T_a_b, check.p_b, {place.most_moved_m, rules_.most_turn_rad}) ||
      r.inlier_fraction < rules_.least_inliers || check.matched.cautious() < rules_.least_matched)
    return std::nullopt;
  check_free_space(check, a, b, r.T_target_source, config);
  if (check.between().violation() > rules_.most_violation) return std::nullopt;
  const Keyframe &from = sessions_.at(id_a).keyframes[place.in_a], &to = sessions_.at(id_b).keyframes[place.in_b];
  return constraint_between({id_a, from.sequence}, from.T_local_sensor, {id_b, to.sequence}, to.T_local_sensor,
                            place_fit(r));
}

}  // namespace headframe
