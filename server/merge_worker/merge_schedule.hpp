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
  travelled,  // ... has come far enough since the last try
  request,    // ... asked for it
  goodbye,    // ... has ended the session
  command,    // the operator asked for it
  restart,    // keyframes came before the server stopped that no attempt has seen
  junction,   // its robot has come to a junction, and not just after the last try
  rest,       // no keyframe has come for a while: it counts as complete until one does
  localize,   // its robot asks where it is, and has come on since it was looked at last
  awaited,    // others have waited long enough for what it comes to say
  poses,      // its robot's SLAM moved its past
};

std::string_view to_string(Trigger trigger);

/// Which session is tried next, and which attempts wait for clouds. Pure: times come in, no thread, no clock. Each
/// session is queued once at most, so the queue is bounded by the number of sessions. Robots share the worker's time:
/// whose sessions have taken the least of it comes first, so that nobody's sessions keep those of others waiting.
class MergeSchedule {
 public:
  using Time = std::chrono::steady_clock::time_point;

  struct Attempt {
    SessionId session = 0;
    Trigger trigger = Trigger::command;
    Time triggered;         // of the first trigger that this attempt answers
    int round = 0;          // how often it has waited for clouds
    bool leftover = false;  // of an attempt that had more to try
  };

  explicit MergeSchedule(const ScheduleConfig& config) : config_(config) {}

  /// Whose session it is; of a session that nobody told it of, its own.
  void belongs(SessionId session, const std::string& robot) { robots_[session] = robot; }

  /// Joins an attempt that is queued already.
  void trigger(SessionId session, Trigger trigger, Time now);
  void travelled(SessionId session, double metres, Time now);
  /// Its robot is at a junction, where tunnels that look alike can be told apart. A try follows when the session has
  /// come config.junction_m since its last one, now or later: of the keyframes at one junction one asks.
  void junction(SessionId session, Time now);

  /// Its robot asks where it is, from now on or no more. The session is then tried at once, before others, and after
  /// each asked_m. Two such tries never follow each other while others wait, and what a try left over has no
  /// precedence, so that nobody keeps the others waiting by asking.
  void asks_where(SessionId session, bool asks, Time now);

  /// A keyframe came, so the session grows; its robot asks for a merge; it has ended.
  void grows(SessionId session, Time now);
  void asks(SessionId session, Time now);
  void ended(SessionId session);
  /// Sessions that grew and came to rest since the last call: nothing came for config.rest_s, or for
  /// config.asked_rest_s after their robot asked.
  std::vector<SessionId> come_to_rest(Time now);
  /// Sessions that grew, and for which the merges of others have waited since the last call as long as they may:
  /// config.awaited_s from when the robot's first session grew. An hour after that its new sessions are awaited again.
  std::vector<SessionId> waited_out(Time now);

  /// Of the robots that ask where they are, then of all, whose turn it is: the attempt that was queued first. It counts
  /// as the session's last try.
  std::optional<Attempt> next();
  /// The worker's time that the session's attempt took.
  void spent(SessionId session, double seconds);
  /// Behind what is queued: the attempt has more to try.
  void again(const Attempt& attempt);

  /// The attempt waits until all these clouds have come or will not come, then it is queued again. Returns those that
  /// have to be asked for now: the others are awaited already. After most_rounds the attempt is let go.
  std::vector<KeyframeRef> wait_for(Attempt attempt, const std::vector<KeyframeRef>& wanted, Time now);
  void cloud_came(const KeyframeRef& cloud, Time now);
  void cloud_will_not_come(const KeyframeRef& cloud);
  void robot_came(SessionId session);
  void robot_left(SessionId session);
  /// Clouds that a robot has not sent for config.submap_s will not come.
  void tick(Time now);
  std::optional<Time> next_deadline() const;

  /// Asked for in vain since its robot connected last.
  bool in_vain(const KeyframeRef& cloud) const { return in_vain_.contains(cloud); }

  std::size_t queued() const { return queue_.size(); }
  std::size_t awaited() const { return awaited_.size(); }

  static constexpr double asked_m = 2;    // as travelled_m, while its robot asks where it is
  static constexpr int most_rounds = 50;  // ten hypotheses one by one, more of the overlap, contacts one by one

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
  double turn_s_ = 0;                     // what the robot had used whose turn was last: who idles saves up nothing
  std::vector<Waiting> waiting_;          // one for each session at most
  std::set<KeyframeRef> awaited_, in_vain_;
  std::map<SessionId, Time> deadlines_;                     // of robots that owe clouds
  std::map<SessionId, Time> rests_at_;                      // of sessions that grow
  std::map<std::string, Time> first_grew_;                  // by robot, in this hour
  std::map<SessionId, std::optional<Time>> awaited_until_;  // none: no more
  std::map<SessionId, double> travelled_m_;
  std::set<SessionId> at_junction_;  // since their last try
  std::set<SessionId> ask_where_;
  bool asker_was_last_ = false;
};

}  // namespace headframe
