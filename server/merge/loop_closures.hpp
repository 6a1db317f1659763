#pragma once
// Loop closures: places that were seen at two times, by one session or by two that are merged, registered on each other
// by themselves. They bend sessions in the pose graph and merge nothing.

#include <optional>
#include <set>

#include "server/atlas/alignment.hpp"
#include "server/merge/attempt.hpp"
#include "server/merge/session_submaps.hpp"

namespace headframe {

/// What is asked of a loop closure before the pose graph hears of it. Set by hand; one that is left out leaves odometry
/// as it is.
struct LoopClosureRules {
  double apart_m = 95;          // of path between two times of one session: their submaps share no cloud
  double near_m = 5;            // between two keyframes of a session, as odometry has them ...
  double drift = 0.01;          // ... and so much more for each metre of path between
  double farthest_m = 9;        // ... but no more; between keyframes of two sessions
  double every_m = 8;           // of path, one loop closure
  std::size_t at_once = 12;     // registrations in one attempt, at most
  double least_inliers = 0.4;   // of the points
  double least_matched = 0.75;  // of the points that the other time can speak of
  double most_violation = 0.02;
  double most_moved_m = 2;     // by the registration, between two sessions: farther off lies another placement
  double most_turn_rad = 0.1;  // the same
};

/// Owns what was tried. Not thread safe.
class LoopClosures {
 public:
  LoopClosures(const SessionMap& sessions, SessionSubmaps& submaps) : sessions_(sessions), submaps_(submaps) {}

  /// Registers the next places where the session meets itself, or one that it is merged with, of clouds that are
  /// stored: at most LoopClosureRules::at_once; the attempt is unfinished when there are more. Gives, for each pair for
  /// which any was found, all that are known. `alignments`: of all sessions, in local frames.
  std::vector<PairClosures> find(SessionId session, std::span<const Alignment> alignments, const Attempt& attempt);

  /// As they were stored.
  void restore(const PairClosures& closures);
  void forget(SessionId session);

 private:
  using Pair = std::pair<SessionId, SessionId>;
  struct Known {
    Pose T_a_b = Pose::Identity();         // of the placement that they are of
    std::map<int, PoseConstraint> places;  // by the piece of b's path that they lie on
    std::set<int> tried;                   // pieces
  };
  struct Place {
    std::size_t in_a = 0, in_b = 0;  // keyframes
    Pose T_a_b = Pose::Identity();   // there, as far as it is known
    double most_moved_m = 0;
  };
  class Search;  // of the places of one pair

  std::optional<PoseConstraint> registered(const Pair& pair, const Place& place, CloudSource& clouds);
  int piece_of(const Session& session, std::size_t keyframe) const;

  const LoopClosureRules rules_ = {};
  const SessionMap& sessions_;
  SessionSubmaps& submaps_;
  std::map<Pair, Known> known_;
};

}  // namespace headframe
