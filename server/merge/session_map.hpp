#pragma once
// The sessions of the merge pipeline, each in a local frame near zero.

#include <Eigen/Geometry>
#include <map>
#include <string>

#include "server/atlas/frozen.hpp"
#include "server/merge/merge_config.hpp"
#include "server/merge/ordered_pair.hpp"
#include "server/merge/session_frames.hpp"
#include "server/place/descriptor_agreement.hpp"

namespace headframe {

struct Session {
  FamilyId family;
  std::string site;  // the mine it was driven in; empty: the operator has only one
  std::vector<Keyframe> keyframes;
  std::vector<double> path_to_m;  // to each keyframe
  Eigen::AlignedBox3d box;        // around all keyframes
  bool complete = false;          // no keyframe is expected: it ended, or paused
  bool looked_at = false;         // ... and was since tried with all other sessions
  bool awaited = true;            // merges of others may wait for this session's evidence
  bool asks_where = false;        // its robot asks where it is: it is tried however short it is
  std::size_t asked = 0;          // keyframes that were compared with their neighbours
  std::uint64_t fingerprint = 0;  // of the first keyframe as received: the same whenever the session is added

  void add(Keyframe keyframe);
  /// Strips keyframes that do not match their neighbours (fits_neighbours) of walls, cloud and descriptor; they keep
  /// their place on the path.
  void set_aside_outliers();
  /// Distance of p, in its local frame, from its nearest keyframe; infinite if it has none.
  double distance_m(const Eigen::Vector3d& p) const;
  Eigen::Vector3d middle() const { return keyframes[keyframes.size() / 2].T_local_sensor.translation(); }
  double path_m() const { return path_to_m.empty() ? 0 : path_to_m.back(); }
};

/// Owns all sessions and their frames. Not thread safe.
class SessionMap {
 public:
  explicit SessionMap(const MergeConfig& config) : config_(config) {}

  bool contains(SessionId id) const { return sessions_.contains(id); }
  const Session& at(SessionId id) const { return sessions_.at(id); }
  const std::map<SessionId, Session>& all() const { return sessions_; }
  const SessionFrames& frames() const { return frames_; }

  void add(SessionId id, const FamilyId& family, const std::string& site = {}) {
    sessions_[id].family = family;
    sessions_[id].site = site;
  }
  void set_site(SessionId id, const std::string& site) { sessions_[id].site = site; }
  bool at_one_site(SessionId one, SessionId other) const { return at(one).site == at(other).site; }
  /// Adds the keyframe and returns it as stored; the session is no longer complete.
  const Keyframe& add_keyframe(SessionId id, Keyframe keyframe);
  void complete(SessionId id);
  void set_looked_at(SessionId id, bool looked_at);
  void await_no_more(SessionId id) { sessions_[id].awaited = false; }
  void set_asks_where(SessionId id, bool asks) { sessions_[id].asks_where = asks; }
  void forget(SessionId id);

  /// Sessions that nothing may move, in the robots' frames; includes sessions that are set aside.
  const FrozenSessions& frozen() const { return frozen_; }
  void freeze(FrozenSession session) { frozen_[session.session] = std::move(session); }
  /// Returns false if it was not frozen.
  bool thaw(SessionId id) { return frozen_.erase(id) > 0; }

  /// The longer session is placed on the shorter one, because it is placed piece by piece, and more pieces find more.
  /// (With the shorter of the campus drives placed on the longer, the search missed the right placement at 4 of 24
  /// rotations, otherwise at none.)
  OrderedPair ordered(SessionId one, SessionId other) const;

  /// Compares the descriptors along both paths, for the verdict. Empty if the sessions have different families or
  /// versions, or a family that the verdict's weights were not fitted on.
  DescriptorAgreement descriptor_agreement(const OrderedPair& pair) const;

  /// A few metres of path look like many other places, so a growing session waits until it is longer.
  bool may_merge(SessionId id) const { return at(id).complete || at(id).path_m() >= config_.least_path_m; }
  bool may_merge(const OrderedPair& pair) const { return may_merge(pair.a) && may_merge(pair.b); }
  /// Of how many of the two no further keyframe is expected.
  int how_many_ended(const OrderedPair& pair) const { return int{at(pair.a).complete} + int{at(pair.b).complete}; }
  bool have_ended(const OrderedPair& pair) const { return how_many_ended(pair) == 2; }
  /// Whether the pair, of one site, is tried at all: both may merge, or one may merge and the other's robot asks where
  /// it is.
  bool worth_a_look(const OrderedPair& pair) const {
    return at_one_site(pair.a, pair.b) && (may_merge(pair) || (may_merge(pair.a) && at(pair.b).asks_where) ||
                                           (may_merge(pair.b) && at(pair.a).asks_where));
  }

  /// Path in metres that a growing session still has to drive before a placement is published, according to
  /// MergeConfig::shown_m. It is more where places look alike; there, other sessions that may contradict the placement
  /// are waited for too (for one metre if a session has ended and was not tried since). A complete session has shown
  /// all it can, unless it is short: its whole path has to reach short_m, more for look-alikes and doubt, but at most
  /// most_of_short_m or MergeConfig::shown_m. 0: nothing is missing.
  /// Other growing sessions of the site are waited for only while they drive: at least least_step_m of path for each
  /// keyframe, except for the of_a_turn keyframes of a turn on the spot. So a robot that sends many keyframes of one
  /// spot delays nobody; await_no_more() is for one that drives slowly.
  double path_awaited_m(const OrderedPair& pair, const Pose& T_a_b, const Evidence& evidence) const;

  static constexpr double localize_m = 20;  // set by hand, like the following:
  static constexpr double short_m = 20, most_of_short_m = 50;
  static constexpr double least_step_m = 0.25, of_a_turn = 12;
  /// The same for telling a robot that asks where it is: uses localize_m instead of MergeConfig::shown_m, also if the
  /// session is complete. In a mine that looks like itself (looks_like_itself()) up to shown_m is demanded: a robot
  /// that starts in a part nobody has mapped finds only a copy of it there (50 m long, in a mine of equal tunnels).
  double path_awaited_to_localize_m(SessionId asking, const OrderedPair& pair, const Pose& T_a_b,
                                    const Evidence& evidence) const;

 private:
  const MergeConfig config_;
  SessionFrames frames_;
  double path_asked_m(const Evidence& evidence, double least_m) const;
  double path_awaited_of_others_m(const OrderedPair& pair, double asked_m) const;
  static bool drives_on(const Session& session);

  std::map<SessionId, Session> sessions_;
  FrozenSessions frozen_;
};

}  // namespace headframe
