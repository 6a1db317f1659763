#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "server/merge_worker/schedule_config.hpp"
#include "server/session/ids.hpp"

namespace headframe {

/// Why a session is tried.
enum class Trigger {
  link,       // its robot has connected
  travelled,  // ... has driven far enough since the last try
  request,    // ... asked for it
  goodbye,    // ... has ended the session
  command,    // the operator asked for it
  restart,    // an earlier run of the server stored keyframes that no attempt has used
  junction,   // its robot has reached a junction, some way after the last try
  rest,       // no keyframe has come for a while: it counts as complete until one does
  localize,   // its robot asks where it is, and has driven on since the last try
  awaited,    // other sessions no longer wait for this one's evidence
  poses,      // its robot's SLAM moved earlier keyframes
};

std::string_view to_string(Trigger trigger);

/// Decides which session is tried next, and which attempts wait for clouds. Pure: times are passed in; no thread, no
/// clock. Each session is queued at most once, so the queue is bounded by the number of sessions. Robots share the
/// worker's time: the robot whose sessions have used the least of it comes first, so that none can keep the others
/// waiting.
class MergeSchedule {
 public:
  using Time = std::chrono::steady_clock::time_point;

  struct Attempt {
    SessionId session = 0;
    Trigger trigger = Trigger::command;
    Time triggered;         // of the first trigger that led to this attempt
    int round = 0;          // how often it has waited for clouds
    bool leftover = false;  // the rest of an attempt that had more to try
  };

  explicit MergeSchedule(const ScheduleConfig& config) : config_(config) {}

  /// Sets the robot of a session. A session without one counts as a robot of its own.
  void belongs(SessionId session, const std::string& robot) { robots_[session] = robot; }

  /// Queues an attempt; joins one of the session that is queued already.
  void trigger(SessionId session, Trigger trigger, Time now);
  void travelled(SessionId session, double metres, Time now);
  /// The session's robot is at a junction, where similar tunnels can be told apart. The session is tried once it has
  /// driven config.junction_m since its last try, now or later; so only one of the keyframes at a junction causes a
  /// try.
  void junction(SessionId session, Time now);

  /// The session's robot starts or stops asking where it is. The session is then tried at once, before others, and
  /// after each asked_m. Two such tries never follow each other while others wait, and the rest of a try has no
  /// priority, so that asking cannot keep others waiting.
  void asks_where(SessionId session, bool asks, Time now);

  /// A keyframe came, so the session grows; its robot asked for a merge; the session ended.
  void grows(SessionId session, Time now);
  void asks(SessionId session, Time now);
  void ended(SessionId session);
  /// Growing sessions that have paused since the last call: without a keyframe for config.rest_s, or for
  /// config.asked_rest_s after their robot asked for a merge.
  std::vector<SessionId> come_to_rest(Time now);
  /// Growing sessions that merges of others stop waiting for since the last call: these wait at most config.awaited_s
  /// from when the robot's first session started to grow. An hour after that start, new sessions of the robot are
  /// waited for again.
  std::vector<SessionId> waited_out(Time now);

  /// The next attempt: first of robots that ask where they are, then of all; of the robot that used the least time, and
  /// of several the one queued first. Counts as the session's last try.
  std::optional<Attempt> next();
  /// Records the worker's time that an attempt for the session took.
  void spent(SessionId session, double seconds);
  /// Queues the attempt again, behind all others, because it has more to try.
  void again(const Attempt& attempt);

  /// Lets the attempt wait until all these clouds have come or will not come; then it is queued again. Returns the
  /// clouds that have to be requested now; the others were requested before. After most_rounds the attempt is dropped.
  std::vector<KeyframeRef> wait_for(Attempt attempt, const std::vector<KeyframeRef>& wanted, Time now);
  void cloud_came(const KeyframeRef& cloud, Time now);
  void cloud_will_not_come(const KeyframeRef& cloud);
  void robot_came(SessionId session);
  void robot_left(SessionId session);
  /// Gives up on clouds that a robot has not sent for config.submap_s.
  void tick(Time now);
  std::optional<Time> next_deadline() const;

  /// Whether the cloud was requested without success since its robot last connected.
  bool in_vain(const KeyframeRef& cloud) const { return in_vain_.contains(cloud); }

  std::size_t queued() const { return queue_.size(); }
  std::size_t awaited() const { return awaited_.size(); }

  static constexpr double asked_m = 2;    // like travelled_m, while its robot asks where it is
  static constexpr int most_rounds = 50;  // for ten hypotheses, more of the overlap and contacts, one by one

 private:
  struct Waiting {
    Attempt attempt;
    std::set<KeyframeRef> missing;
  };

  void enqueue(const Attempt& attempt);
  std::deque<Attempt>::iterator whose_turn();
  std::string robot_of(SessionId session) const;
  double& used_s(SessionId session);
  void settle(const KeyframeRef& cloud);
  void give_up(SessionId session);
  static Time after(Time now, double seconds);

  ScheduleConfig config_;
  std::deque<Attempt> queue_;
  std::map<SessionId, std::string> robots_;
  std::map<std::string, double> used_s_;  // by robot
  double turn_s_ = 0;                     // used_s_ of the robot whose turn was last; idle robots save up no time
  std::vector<Waiting> waiting_;          // at most one for each session
  std::set<KeyframeRef> awaited_, in_vain_;
  std::map<SessionId, Time> deadlines_;                     // of robots that have not yet sent requested clouds
  std::map<SessionId, Time> rests_at_;                      // of growing sessions
  std::map<std::string, Time> first_grew_;                  // by robot, in this hour
  std::map<SessionId, std::optional<Time>> awaited_until_;  // nullopt: no longer
  std::map<SessionId, double> travelled_m_;
  std::set<SessionId> at_junction_;  // since their last try
  std::set<SessionId> ask_where_;
  bool asker_was_last_ = false;
};

}  // namespace headframe
