#pragma once
// The interface between the merge worker and the robots: news go in, requests and transforms come out.

#include <string>
#include <vector>

#include "common/session/keyframe.hpp"
#include "server/atlas/atlas.hpp"
#include "server/merge/localization.hpp"
#include "server/merge_worker/merge_schedule.hpp"
#include "server/session/session_cut.hpp"

namespace headframe {

struct NewSession {
  std::string robot;
  FamilyId family;
  std::string site = {};  // as SessionRecord::site
};

/// What the worker is told. Thread safe, fast, never blocks: news of a session are combined until the worker takes
/// them.
class MergeNews {
 public:
  virtual ~MergeNews() = default;
  virtual void session_added(SessionId session, const NewSession& added) = 0;
  virtual void keyframes_durable(SessionId session, std::uint64_t sequence) = 0;
  /// The robot moved earlier keyframes of the session (Store::new_poses).
  virtual void poses_durable(SessionId session) = 0;
  virtual void cloud_durable(const KeyframeRef& cloud) = 0;
  virtual void clouds_unavailable(SessionId session, const std::vector<std::uint64_t>& sequences) = 0;
  /// answers: whether the robot will answer submap requests.
  virtual void robot_came(SessionId session, bool answers) = 0;
  virtual void robot_left(SessionId session) = 0;
  virtual void trigger(SessionId session, Trigger trigger) = 0;
  /// The session's robot starts or stops asking where it is; disconnecting also stops it. Each call with `asks` is
  /// answered at once with what is known, and again whenever that changes (Robots::tell_localization).
  virtual void asks_where(SessionId session, bool asks) = 0;
};

/// A published merge that was taken back because of later evidence.
struct Withdrawal {
  SessionId a = 0, b = 0;
  std::string reason;
};

/// What the worker tells and asks the robots. Called from the worker's thread; must not block.
class Robots {
 public:
  virtual ~Robots() = default;
  virtual void request_submap(SessionId session, const std::vector<std::uint64_t>& sequences) = 0;
  /// Called when the atlas is durable; `changed` are the components whose robots have to be told.
  virtual void publish(const Atlas& atlas, const std::vector<Component>& changed,
                       const std::vector<Withdrawal>& withdrawn) = 0;
  /// The revision is unchanged; the provisional placements of `changed` are news for the robots that ask for them.
  virtual void tell_provisional(const Atlas& atlas, const std::vector<Component>& changed) = 0;
  /// Tells the robot of this session, which asks where it is.
  virtual void tell_localization(SessionId session, const SessionLocalization& localization) = 0;
  /// Keyframes of this session were moved in its local frame.
  virtual void tell_moved(SessionId /*session*/) {}
  /// Keyframes of this session are left out of merging from now on, or none are any longer.
  virtual void tell_cut(SessionId session, const SessionCut& cut) = 0;
};

/// Components of `now` whose robots have to be told: their placements changed, or a session that was merged is alone
/// again.
std::vector<Component> changed_components(const Atlas& before, const Atlas& now);

/// Components of `now` whose provisional placements changed.
std::vector<Component> changed_provisionals(const Atlas& before, const Atlas& now);

}  // namespace headframe
