#pragma once
// Loop closures: places that were seen at two times, by one session or by two merged ones, registered independently.
// They bend sessions in the pose graph and never merge anything.

#include <optional>
#include <set>

#include "server/atlas/alignment.hpp"
#include "server/merge/attempt.hpp"
#include "server/merge/session_submaps.hpp"

namespace headframe {

/// What a loop closure has to satisfy to enter the pose graph. Set by hand; without a loop closure, the odometry stays
/// as it is.
struct LoopClosureRules {
  double apart_m = 95;          // path between two visits of one session, so that their submaps share no cloud
  double near_m = 5;            // greatest distance of two keyframes of a session by odometry ...
  double drift = 0.01;          // ... plus this for each metre of path between them
  double farthest_m = 9;        // ... but at most this; also the limit for keyframes of two sessions
  double every_m = 8;           // path for each loop closure
  std::size_t at_once = 12;     // registrations in one attempt
  double least_inliers = 0.4;   // of the points
  double least_matched = 0.75;  // of the points that the other visit can confirm or contradict
  double most_violation = 0.02;
  double most_moved_m = 2;     // by the registration, for two sessions: beyond, it is another placement
  double most_turn_rad = 0.1;  // the same
};

/// Keeps what was found and tried. Not thread safe.
class LoopClosures {
 public:
  LoopClosures(const SessionMap& sessions, SessionSubmaps& submaps) : sessions_(sessions), submaps_(submaps) {}

  /// Registers the next places where the session meets itself, or a session that it is merged with, using stored
  /// clouds: at most LoopClosureRules::at_once places; if more are left, the attempt is marked unfinished. Returns, for
  /// each pair with new loop closures, all that are known. `alignments`: of all sessions, in local frames.
  std::vector<PairClosures> find(SessionId session, std::span<const Alignment> alignments, const Attempt& attempt);

  /// Restores stored loop closures.
  void restore(const PairClosures& closures);
  void forget(SessionId session);

 private:
  using Pair = std::pair<SessionId, SessionId>;
  struct Known {
    Pose T_a_b = Pose::Identity();         // the placement that they belong to
    std::map<int, PoseConstraint> places;  // by piece of b's path
    std::set<int> tried;                   // pieces of b's path
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
