#pragma once

#include <atomic>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <set>

#include "server/merge_worker/merge_news.hpp"
#include "server/net/data_rate.hpp"
#include "server/net/fair_pool.hpp"
#include "server/net/link_health.hpp"
#include "server/net/robot_events.hpp"
#include "server/net/robot_limits.hpp"
#include "server/net/robot_quota.hpp"
#include "server/net/surroundings_desk.hpp"
#include "server/net/transform_pages.hpp"
#include "server/session/session_row.hpp"
#include "server/store/store.hpp"

namespace headframe {

/// How connections went, for the operator. Thread safe.
struct LinkCounts {
  std::atomic<std::uint64_t> refused = 0, replaced = 0, failed = 0, stuck = 0, held_back = 0, sent_bytes = 0,
                             refused_clouds = 0;  // as in LinkHealth
};

/// One robot's connection, as the hub sees it. Thread safe, never blocks.
class RobotLink {
 public:
  virtual ~RobotLink() = default;
  /// Received bytes have become durable, or with a failure will not: the connection then ends and the robot repeats.
  virtual void settled(std::size_t bytes, const Result<void>& result) = 0;
  virtual void keyframes_durable(std::uint64_t sequence) = 0;
  virtual void poses_durable(std::uint64_t update) = 0;
  virtual void cloud_durable(std::uint64_t sequence) = 0;
  virtual void cloud_refused(std::uint64_t sequence, const std::string& reason) = 0;
  virtual void request_submap(const std::vector<std::uint64_t>& sequences) = 0;
  virtual void update_transform(std::shared_ptr<const TransformPages> pages) = 0;
  virtual void tell_localization(std::shared_ptr<const std::string> payload) = 0;
  virtual void tell_surroundings(SurroundingsKind kind, std::shared_ptr<const std::string> payload) = 0;
  /// Another connection carries the session from now on.
  virtual void stand_by() = 0;
  virtual void close(v1::ErrorKind kind, const std::string& message, bool permanent) = 0;
};

/// Every session there is and who is connected: where the robots' events meet the store and the merge worker. Thread
/// safe; never blocks on the disk but in restore().
class SessionHub : public Robots {
 public:
  SessionHub(Store& store, MergeNews& news, const RobotLimits& limits = {});

  Result<void> restore();
  /// What robots ask about others is answered no more, and nothing of it reads the store any longer.
  void stop_answers() { desk_.stop(); }

  struct Admitted {
    SessionId session = 0;
    Durable durable;
    std::shared_ptr<const TransformPages> transform;  // null: the session has never been merged
  };
  /// refused: the session belongs to another spool or another copy of it, or has another family. unavailable: as many
  /// robots as limits.robots are connected, or the robot's own quota is used up. A living connection of the same spool
  /// is replaced: the robot has noticed before us that it broke. From here on the hub writes to the link. A spare
  /// disturbs none: it has to be of the same run of the spool (else unavailable), and of more than limits.spares the
  /// oldest is closed. Where nobody carries the session it does.
  Result<Admitted> admit(const Hello& hello, const std::shared_ptr<RobotLink>& link);
  /// Runs on a thread of its own kind, in turns with what other robots cause: see FairPool.
  void work_for(SessionId session, FairPool::Work work);
  /// Takes any event but the hello, the probe and the cloud that was not checked.
  void take(SessionId session, RobotEvent event, const std::shared_ptr<RobotLink>& link);
  void received(SessionId session, std::size_t bytes);
  void left(SessionId session, const RobotLink* link);
  /// Answers what the session asks about others, when there is an answer; to be called often.
  void look_around(SessionId session, const RobotLink* link);
  std::uint64_t durable_keyframes(SessionId session) const;
  /// It was deleted: its connections end, and its robot is told to begin another.
  void forget(SessionId session);
  /// Ends all connections of this robot, for good.
  void end_robot(const std::string& robot, const std::string& why);

  void request_submap(SessionId session, const std::vector<std::uint64_t>& sequences) override;
  void publish(const Atlas& atlas, const std::vector<Component>& changed,
               const std::vector<Withdrawal>& withdrawn) override;
  void tell_provisional(const Atlas& atlas, const std::vector<Component>& changed) override;
  void tell_localization(SessionId session, const SessionLocalization& localization) override;
  /// For good: what follows is a session of its own from now on, in everything but the robot's eyes. It is named
  /// NAME~N for the robot's N-th keyframe, its first; at most most_parts of one session are made.
  void tell_cut(SessionId session, const SessionCut& cut) override;
  void tell_moved(SessionId session) override;
  static constexpr std::size_t most_parts = 8;

  /// What all robots together may send, in bytes per second, shared by those that are connected; 0: no limit. May
  /// change while they are served.
  void set_uplink_budget(std::uint64_t bytes_per_s) { budget_bytes_per_s_ = bytes_per_s; }

  LinkCounts& counts() { return counts_; }

  /// As it is now: every robot's share of the budget, and a hold while the store waits for room on the disk or has half
  /// of its queue full. Its changes are logged.
  LinkPolicy policy();
  /// The same for one session: its robot's own rate counts when it is the smaller, and what is left out of merging is
  /// said.
  LinkPolicy policy_of(SessionId session);
  /// What this robot may send at most, in bytes per second; 0: no limit of its own. Told within a tick.
  void set_rate(const std::string& robot, std::uint64_t bytes_per_s);

  /// Sessions that this robot begins from now on are of this site; empty: of none. `done` runs once, when it is durable
  /// or with why not: invalid_argument (no name), refused (too many robots have one), unavailable.
  void set_robot_site(const std::string& robot, const std::string& site, std::function<void(const Result<void>&)> done);
  std::map<std::string, std::string> robot_sites() const;
  static constexpr std::size_t most_robot_sites = 10'000;
  /// The session is of another site than was thought, as it was stored.
  void set_site(SessionId session, const std::string& site);

  /// Clouds that were deleted so that others find room; its robot keeps on counting them as sent.
  void let_go(SessionId session, const std::vector<std::uint64_t>& sequences);

  /// distance_m and trigger_to_transform_ms are not the hub's to fill.
  std::vector<SessionRow> sessions() const;
  std::map<SessionId, SessionKey> keys() const;
  /// Writes that were received and are not settled. Falls only after the worker and the robot were told.
  std::size_t unsettled() const { return unsettled_; }

  /// What an event counts in settled(): 0 when nothing of it is stored.
  static std::size_t stored_bytes(const RobotEvent& event);

  /// For the log: ROBOT/SESSION.
  static std::string name_of(const SessionKey& key) { return key.robot + "/" + key.session; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Session {
    SessionRecord record;
    std::uint64_t keyframes = 0;             // durable
    std::set<std::uint64_t> clouds, let_go;  // that came; of them those that made room for others
    std::uint64_t bytes_received = 0, cloud_bytes = 0;
    std::uint64_t refused_clouds = 0;
    std::uint64_t backlog = 0;  // keyframes that the robot still holds, as it said last
    DataRate rate;
    std::optional<LiveRow> live;  // without its age
    Clock::time_point live_came;
    Clock::time_point heard;
    std::weak_ptr<RobotLink> link;
    std::vector<std::weak_ptr<RobotLink>> spares;  // the oldest first
    bool answers = false;                          // requests for clouds
    bool wants_provisional = false;                // merges that still wait for path
    bool takes_pages = false;                      // of transforms
    bool takes_supports = false;                   // of transforms
    bool asks_where = false;                       // over the connection that carries it
    bool deleted = false;                          // nobody may go on with it
    SessionCut cut;
    std::uint64_t moves = 0;       // how often its keyframes were moved, since the server began
    SessionId whole = 0;           // the session that this is a part of, as its robot has it; 0: it is none
    std::uint64_t from = 1;        // the robot's number of its first keyframe
    std::vector<SessionId> parts;  // that follow a whole, in order
    bool split_waits = false;      // its beginning is still to be stored
  };
  static constexpr std::size_t most_withdrawn = 16;  // an update has to stay small
  using Applied = std::function<void()>;
  using Rejected = std::function<bool(const Error&)>;  // by itself: all else can be written; false: to be repeated

  // session_hub_parts.cpp: what carries the connection of a session is its last part. Under the lock.
  std::vector<SessionId> with_parts(SessionId session) const;
  SessionId last_part(SessionId session) const { return with_parts(session).back(); }
  SessionId before(SessionId part) const;
  Session& carrier(SessionId session) { return sessions_.at(last_part(session)); }
  const Session& carrier(SessionId session) const { return sessions_.at(last_part(session)); }
  KeyframeRef stored_as(SessionId session, std::uint64_t sent) const;
  Durable durable_of(SessionId session) const;
  void tell_came(SessionId session);
  void tell_left(SessionId session);
  void tell_unavailable(SessionId session, const std::vector<std::uint64_t>& sent);
  void split(SessionId session);
  SessionId new_part(SessionId session, const SessionKey& key);
  void store_split(SessionId part);
  void split_stored(SessionId part, bool stored);
  void find_parts();
  std::string cut_text(SessionId session, std::uint64_t counted_before) const;
  std::string cut_text_for_robot(SessionId session) const;
  SessionKey key_for(SessionId receiver, SessionId session) const;

  Session& session_of(const Hello& hello);
  /// Why there is none for this robot; empty: there is.
  std::string want_of_room(const Hello& hello) const;
  void write(Write write, const std::shared_ptr<RobotLink>& link, std::size_t bytes, Applied applied,
             Rejected rejected = {});
  bool over_quota(SessionId session, int keyframes, const std::shared_ptr<RobotLink>& link, std::size_t bytes);
  void note_refusal(SessionId session, const CloudRefused& cloud);
  void handle(SessionId session, KeyframeReceived event, const std::shared_ptr<RobotLink>& link, std::size_t bytes);
  void handle(SessionId session, const PosesReceived& event, const std::shared_ptr<RobotLink>& link, std::size_t bytes);
  PutPoses as_stored(SessionId session, const PosesReceived& event) const;
  void handle(SessionId session, CloudReceived event, const std::shared_ptr<RobotLink>& link, std::size_t bytes);
  void handle(SessionId session, const GoodbyeReceived& event, const std::shared_ptr<RobotLink>& link);
  void handle(SessionId session, LiveReceived event, const std::shared_ptr<RobotLink>& link);
  void handle(SessionId session, const WhereAsked& event, const std::shared_ptr<RobotLink>& link);
  template <class Question>
  void ask(SessionId session, const Question& question, const std::shared_ptr<RobotLink>& link);
  SessionSurroundings surroundings_of(SessionId session) const;
  std::optional<Result<Admitted>> stand_by(const Hello& hello, const std::shared_ptr<RobotLink>& link);
  void take_over(SessionId session, const std::shared_ptr<RobotLink>& link);
  using PagesPtr = std::shared_ptr<const TransformPages>;
  struct Told {  // of a component's transforms; what a robot can take of it
    bool provisional = false, supports = false, in_pages = false;
    SessionId part = 0;  // the robot's, who knows its whole alone; 0: it has no parts
    auto operator<=>(const Told&) const = default;
  };
  using MadePages = std::map<Told, PagesPtr>;
  PagesPtr transform_of(SessionId session) const;
  v1::TransformUpdate update_of(const Component& component, const Told& told) const;
  PagesPtr pages_for(SessionId receiver, const Component& component, MadePages& made) const;
  using Updates = std::vector<std::pair<std::shared_ptr<RobotLink>, PagesPtr>>;
  void add_updates(const Component& component, bool all, Updates& updates) const;
  std::shared_ptr<RobotLink> link_of(SessionId session) const;

  Store& store_;
  MergeNews& news_;
  const RobotLimits limits_;
  mutable std::mutex mutex_;
  std::map<SessionId, Session> sessions_;
  std::map<SessionKey, SessionId> ids_;
  Atlas atlas_;                                                 // published last
  std::deque<std::pair<std::uint64_t, Withdrawal>> withdrawn_;  // with their revisions; the newest most_withdrawn
  std::set<SessionId> told_;  // sessions that were part of a component once: they hear of it when they connect
  std::atomic<std::size_t> unsettled_ = 0;
  std::map<std::string, std::uint64_t> rates_bytes_per_s_;  // of robots that have one of their own
  std::map<std::string, std::string> robot_sites_;          // of robots that have one; as on the disk
  LinkCounts counts_;
  std::atomic<std::uint64_t> budget_bytes_per_s_ = 0;
  std::mutex policy_mutex_;  // taken before mutex_
  LinkPolicy policy_;
  Clock::time_point policy_made_;
  RobotQuota quota_;
  FairPool decoding_{2};  // these two last: their work is done before what it uses goes
  SurroundingsDesk desk_;
};

}  // namespace headframe
