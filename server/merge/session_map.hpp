#pragma once
// The sessions as the merge pipeline keeps them, each in a local frame near zero.

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
  std::string site;  // the mine it was driven in; empty: the operator has one alone
  std::vector<Keyframe> keyframes;
  std::vector<double> path_to_m;  // to each keyframe
  Eigen::AlignedBox3d box;        // around all keyframes
  bool complete = false;          // no keyframe is expected: it ended, or rests
  bool looked_at = false;         // ... and was tried since, with every other session
  bool awaited = true;            // merges of others may wait for what it comes to say
  bool asks_where = false;        // its robot asks where it is: looked at however short it is
  std::size_t asked = 0;          // keyframes whose neighbours were asked whether they see the same
  std::uint64_t fingerprint = 0;  // of the first keyframe as it came: the same whenever the session comes

  void add(Keyframe keyframe);
  /// Keyframes that fit none of their neighbours keep their place on the path and nothing else: no walls, no cloud, no
  /// descriptor.
  void set_aside_outliers();
  /// Whether a keyframe of it stands nearer than this to p, in its local frame.
  bool passes_near(const Eigen::Vector3d& p, double reach_m) const;
  Eigen::Vector3d middle() const { return keyframes[keyframes.size() / 2].T_local_sensor.translation(); }
  double path_m() const { return path_to_m.empty() ? 0 : path_to_m.back(); }
};

/// Owns all sessions, and the frames that they came in. Not thread safe.
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
  /// The keyframe as it was taken in; it is complete no more.
  const Keyframe& add_keyframe(SessionId id, Keyframe keyframe);
  void complete(SessionId id);
  void set_looked_at(SessionId id, bool looked_at);
  void await_no_more(SessionId id) { sessions_[id].awaited = false; }
  void set_asks_where(SessionId id, bool asks) { sessions_[id].asks_where = asks; }
  void forget(SessionId id);

  /// Sessions that nothing moves, between the frames of the robots; also of those that are not here now.
  const FrozenSessions& frozen() const { return frozen_; }
  void freeze(FrozenSession session) { frozen_[session.session] = std::move(session); }
  /// False: it was not frozen.
  bool thaw(SessionId id) { return frozen_.erase(id) > 0; }

  /// The longer on the shorter: it is laid piece by piece, and more pieces find more. (With the shorter of the campus
  /// drives laid on the longer, the search missed the right placement at 4 of 24 turns, else at none.)
  OrderedPair ordered(SessionId one, SessionId other) const;

  /// Of the descriptors along both paths, for the verdict. It says nothing where they are of different families or
  /// versions, or of a family that the verdict's weights were not fitted on.
  DescriptorAgreement descriptor_agreement(const OrderedPair& pair) const;

  /// A few metres of path look like many others: a growing session waits until it has seen more.
  bool may_merge(SessionId id) const { return at(id).complete || at(id).path_m() >= config_.least_path_m; }
  bool may_merge(const OrderedPair& pair) const { return may_merge(pair.a) && may_merge(pair.b); }
  /// Whether the pair, of one site, is looked at: also for a robot that asks where it is, against sessions that may
  /// merge.
  bool worth_a_look(const OrderedPair& pair) const {
    return at_one_site(pair.a, pair.b) && (may_merge(pair) || (may_merge(pair.a) && at(pair.b).asks_where) ||
                                           (may_merge(pair.b) && at(pair.a).asks_where));
  }

  /// Path in metres that a session which still grows has to come along before a placement is told, after
  /// MergeConfig::shown_m. Where places look alike it is more, and other sessions are waited for too, which may come to
  /// contradict it: for a metre more if one has ended and was not looked at since. A session that rests or has ended
  /// has shown all it can, unless it is short: of the whole of its path short_m is asked, more for look-alikes and
  /// doubt, and most_of_short_m or MergeConfig::shown_m at most. 0: none.
  /// Of the others at their site that grow those are waited for that drive: least_step_m of path and more for each
  /// keyframe but those of a turn on the spot. Who sends many keyframes of one spot holds nobody up; await_no_more() is
  /// for who takes his time.
  double path_awaited_m(const OrderedPair& pair, const Pose& T_a_b, const Evidence& evidence) const;

  static constexpr double localize_m = 20;  // set by hand, as this:
  static constexpr double short_m = 20, most_of_short_m = 50;
  static constexpr double least_step_m = 0.25, of_a_turn = 12;
  /// The same before its robot, which asks where it is, is told of the placement: after localize_m in place of
  /// MergeConfig::shown_m, also when it rests or has ended. In a mine that looks like itself (looks_like_itself()) no
  /// less than that is asked: who wakes up where nobody was finds a copy there and nothing else (50 m, in a mine of
  /// equal tunnels).
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
