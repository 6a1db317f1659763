#pragma once
// Where the merge worker meets the robots: news go in, requests and transforms come out.

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

/// What the worker is told. Thread safe, quick, never blocks: news of a session join until the worker takes them.
class MergeNews {
 public:
  virtual ~MergeNews() = default;
  virtual void session_added(SessionId session, const NewSession& added) = 0;
  virtual void keyframes_durable(SessionId session, std::uint64_t sequence) = 0;
  /// Its robot said where keyframes that came before lie now (Store::new_poses).
  virtual void poses_durable(SessionId session) = 0;
  virtual void cloud_durable(const KeyframeRef& cloud) = 0;
  virtual void clouds_unavailable(SessionId session, const std::vector<std::uint64_t>& sequences) = 0;
  /// answers: it will answer submap requests.
  virtual void robot_came(SessionId session, bool answers) = 0;
  virtual void robot_left(SessionId session) = 0;
  virtual void trigger(SessionId session, Trigger trigger) = 0;
  /// Its robot asks where it is, until it asks no more or left. Each call with `asks` is answered at once with what is
  /// known, and then whenever that changes (Robots::tell_localization).
  virtual void asks_where(SessionId session, bool asks) = 0;
};

/// A published merge that later evidence took back.
struct Withdrawal {
  SessionId a = 0, b = 0;
  std::string reason;
};

/// What the worker asks for. Called from the worker's thread; must not block.
class Robots {
 public:
  virtual ~Robots() = default;
  virtual void request_submap(SessionId session, const std::vector<std::uint64_t>& sequences) = 0;
  /// The atlas is durable; `changed` are its components whose robots have to hear of it.
  virtual void publish(const Atlas& atlas, const std::vector<Component>& changed,
                       const std::vector<Withdrawal>& withdrawn) = 0;
  /// The same revision; what is provisional of `changed` is news for the robots that ask for it.
  virtual void tell_provisional(const Atlas& atlas, const std::vector<Component>& changed) = 0;
  /// To the robot of this session, which asks where it is.
  virtual void tell_localization(SessionId session, const SessionLocalization& localization) = 0;
  /// Keyframes of this session lie elsewhere in its local frame since.
  virtual void tell_moved(SessionId /*session*/) {}
  /// Keyframes of this session are left out of merging from now on, or none are any more.
  virtual void tell_cut(SessionId session, const SessionCut& cut) = 0;
};

/// Components of `now` that a robot has to hear of: other placements than before, or a session that was merged and
/// stands alone again.
std::vector<Component> changed_components(const Atlas& before, const Atlas& now);

/// Components of `now` of which something else is provisional than before.
std::vector<Component> changed_provisionals(const Atlas& before, const Atlas& now);

}  // namespace headframe
