#pragma once

#include <condition_variable>
#include <deque>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>

#include "server/merge_worker/mailbox.hpp"
#include "server/merge_worker/pipeline.hpp"
#include "server/merge_worker/work_mark.hpp"
#include "server/merge_worker/work_watch.hpp"
#include "server/session/session_row.hpp"
#include "server/store/store.hpp"

namespace headframe {

/// What is known as of the last durable revision.
struct MergeView {
  struct Session {
    double distance_m = 0;
    double trigger_to_transform_ms = -1;  // from the trigger of the attempt that placed it; -1: none has
    std::string why_aside = {};           // why it is set aside; empty: it is not
    bool deleted = false;
    bool archived = false, frozen = false;
    std::string site = {};
  };
  Atlas atlas;  // contains every session that is neither archived nor deleted
  std::vector<Alignment> alignments;
  std::map<SessionId, Session> sessions;
  Corrections corrections = {};  // the poses that the pose graph gives to keyframes
};

/// The one thread that owns the pipeline. It passes durable keyframes from the store to the pipeline, tries sessions in
/// the order of the schedule, stores the changes of an attempt, and only then publishes them. One attempt at a time. A
/// full disk delays merging only; a database that cannot be written ends merging. Thread safe, except restore() and
/// start().
class MergeWorker : public MergeNews, private CloudSource {
 public:
  /// mark: where the sessions being worked on are recorded; without one a crash is not attributed to any session.
  MergeWorker(std::unique_ptr<Pipeline> pipeline, Store& store, const ScheduleConfig& config,
              std::optional<WorkMark> mark = std::nullopt);
  ~MergeWorker() override;  // stop()

  /// Reads the store; once, before start(). The atlas is available at once, as last published; the worker reads the
  /// keyframes later, meanwhile pending() counts them. Sessions with keyframes that no attempt has used are then tried.
  Result<void> restore();
  void start(Robots& robots);
  /// Waits for the running attempt; restore() finds again what is queued.
  void stop();

  void session_added(SessionId session, const NewSession& added) override;
  void keyframes_durable(SessionId session, std::uint64_t sequence) override;
  void poses_durable(SessionId session) override;
  void cloud_durable(const KeyframeRef& cloud) override;
  void clouds_unavailable(SessionId session, const std::vector<std::uint64_t>& sequences) override;
  /// These clouds were deleted to make room for others, and are never requested again.
  void clouds_let_go(SessionId session, const std::vector<std::uint64_t>& sequences);
  void robot_came(SessionId session, bool answers) override;
  void robot_left(SessionId session) override;
  void trigger(SessionId session, Trigger trigger) override;
  void asks_where(SessionId session, bool asks) override;

  /// Queues the operator's decision. `done` is called once: on the worker's thread, when the decision is durable and
  /// the robots were told, or with a failure. unavailable: too many orders wait already, or the server is stopping;
  /// otherwise as MergePipeline::decide.
  void decide(AlignmentId alignment, Decision decision, std::function<void(const Result<void>&)> done);

  /// Judges a placement that the operator made roughly (MergePipeline::place). `done` as for decide(). Clouds are
  /// requested even if it fails.
  void place(SessionId a, SessionId b, const Pose& T_a_b, std::function<void(const Result<HandPlacement>&)> done);

  /// Makes the session's frame the frame of its component; `done` as for decide(). not_found: no such session.
  void anchor(SessionId session, std::function<void(const Result<void>&)> done);

  /// Requests all missing clouds from the session's robot; `done` is called once with their number. not_found: no such
  /// session; refused: its robot is not connected, or sends no clouds.
  void request_clouds(SessionId session, std::function<void(const Result<std::size_t>&)> done);

  /// Stops merging the session, also after a restart; its stored data stays. `done` as for decide(). not_found: no such
  /// session.
  void set_aside(SessionId session, const std::string& why, std::function<void(const Result<void>&)> done);
  /// The session is merged again. refused: it is not set aside.
  void release(SessionId session, std::function<void(const Result<void>&)> done);
  /// Sets the session aside and deletes all its stored data, for good.
  void remove(SessionId session, std::function<void(const Result<void>&)> done);
  /// archived: the session is kept but left out of everything, until it is brought back unchanged with archived =
  /// false. `done` as for decide(); not_found: no such session; refused: it is in this state already.
  void archive(SessionId session, bool archived, std::function<void(const Result<void>&)> done);
  /// frozen: nothing moves the session any more (MergePipeline::freeze), until it is thawed. `done` as for archive();
  /// also refused if it is archived or set aside.
  void freeze(SessionId session, bool frozen, std::function<void(const Result<void>&)> done);

  /// Sets the session's site: it is merged only with sessions of that site. `done` as for archive().
  void set_site(SessionId session, const std::string& site, std::function<void(const Result<void>&)> done);

  Pending pending() const;
  /// Number of operator's orders that the worker has not started.
  std::size_t waiting_orders() const;
  std::shared_ptr<const MergeView> view() const;
  /// What the worker works on now; nullopt: nothing.
  std::optional<WorkPiece> working_on_now() const { return watch_.piece(); }
  /// Why merging counts as stuck; empty if it does not.
  std::string stuck() const;
  /// Attempts since start(), and where their time went.
  MergeEffort effort() const;

 private:
  using Clock = std::chrono::steady_clock;
  using Time = MergeSchedule::Time;
  struct Known {
    std::uint64_t keyframes = 0;
    Eigen::Vector3d last_m = Eigen::Vector3d::Zero();
    std::set<std::uint64_t> stored, without_cloud, let_go;
    bool answers = false;
    bool asks_where = false;
    SessionCut cut = {};
    std::optional<std::uint64_t> feeds_up_to =
        std::nullopt;  // new poses wait that later keyframes lie by; none: to all
    std::string site = {};
    bool more_to_try = false;                                      // its last attempt did not try everything
    std::optional<SessionLocalization> told_where = std::nullopt;  // since its robot asked; nullopt: nothing yet
  };

  /// An operator's order: called once, on the worker's thread, with success or with the reason why it cannot be carried
  /// out.
  using Order = std::function<void(const Result<void>& admitted)>;
  static constexpr std::size_t most_orders = 64, most_unprepared = 4096;
  static constexpr auto look_again_after = std::chrono::milliseconds(200);  // while the store is unreachable

  template <class Change>
  void tell(SessionId session, Change change);
  void run();
  bool wait_for_news(Mailbox& news, std::vector<Order>& orders);
  void rest();
  void turn_away();
  bool prepare_ahead();
  void take(SessionId session, const SessionNews& news);
  void come_to_rest(SessionId session);
  void await_no_more(SessionId session);
  void attempt(const MergeSchedule::Attempt& attempt);
  void give(Order order);
  Result<void> carry_out(AlignmentId alignment, Decision decision);
  Result<void> carry_out_anchor(SessionId session);
  Result<HandPlacement> carry_out_placement(SessionId a, SessionId b, const Pose& T_a_b);
  Result<std::size_t> ask_for_clouds(SessionId session);
  void request(const std::vector<KeyframeRef>& clouds);
  bool commit(PutMerge write, const AttemptReport& report, const MergeSchedule::Attempt* attempt);
  void published(const AttemptReport& report, const MergeSchedule::Attempt* attempt,
                 const std::vector<Withdrawal>& withdrawn);
  // worker_localize.cpp
  void take_question(SessionId session, bool asks);
  void take_question_aside(SessionId session, bool asks);
  void tell_where(bool all);
  std::vector<Withdrawal> withdrawn_by(const AttemptReport& report) const;
  void note_withdrawn(const std::vector<Withdrawal>& withdrawn);
  bool write_durably(const Write& write);
  template <class Read>
  auto read_patiently(const Read& read) -> decltype(read());
  // worker_restore.cpp
  void bring_back();
  static constexpr auto all_keyframes = std::numeric_limits<std::uint64_t>::max();
  void feed(SessionId session, bool counts, std::uint64_t up_to = all_keyframes);
  void bring_in(const SessionRecord& session);
  bool settled(const SessionRecord& session);
  bool has_to_be_tried(const SessionRecord& session);
  // worker_poses.cpp
  void take_in_poses(SessionId session);
  void note_moved(SessionId session, const std::vector<Eigen::Vector3d>& path);
  void catch_up(SessionId session, bool complete);
  // worker_aside.cpp
  Result<void> restore_troubles();
  bool is_aside(SessionId session) const;
  void blame(const WorkMark::Left& left);
  bool tried(const char* what, const std::function<void()>& work);
  void no_work();
  void work_failed();
  void attempt_went_well(SessionId session);
  Result<void> leave_out(SessionId session, PutMerge write);
  Result<void> put_aside(SessionId session, const std::string& why, bool deleted);
  Result<void> take_back(SessionId session);
  // worker_tending.cpp
  Result<void> put_archived(SessionId session, bool archived);
  Result<void> put_frozen(SessionId session, bool frozen);
  Result<void> put_site(SessionId session, const std::string& site);
  std::string why_withdrawn_of(const Alignment& now) const;
  Result<void> bring_in_again(SessionId session, PutMerge write);
  void update_view();

  CloudState state(const KeyframeRef& keyframe) const override;
  Result<CloudDecoder> load(const KeyframeRef& keyframe) override;
  void working_on(SessionId a, SessionId b) override;

  // The worker's thread only.
  std::unique_ptr<Pipeline> pipeline_;
  Store& store_;
  Robots* robots_ = nullptr;
  MergeSchedule schedule_;
  std::map<SessionId, Known> known_;
  std::deque<KeyframeRef> unprepared_;  // clouds that arrived; at most the newest most_unprepared
  std::map<SessionId, TroubleRecord> troubles_;
  std::set<SessionId> archived_, frozen_;
  std::optional<WorkMark> mark_;
  const double stuck_s_;
  WorkWatch watch_;  // any thread
  Atlas atlas_;      // as last published
  struct Stored {
    std::vector<SessionRecord> sessions;
    StoredMerge merge;
  };
  std::optional<Stored> stored_;  // not yet passed to the pipeline
  MergeView draft_;

  struct Bell {
    std::mutex mutex;
    std::condition_variable wake;
  };
  const std::shared_ptr<Bell> bell_ = std::make_shared<Bell>();  // the store may answer when the worker is gone
  std::mutex& mutex_ = bell_->mutex;
  std::condition_variable& wake_ = bell_->wake;
  Mailbox mailbox_;
  std::vector<Order> orders_;
  Pending pending_;  // the schedule's, when the worker last looked
  MergeEffort effort_;
  bool busy_ = false, stopping_ = false;
  bool ahead_ = false;                            // used by the worker's thread only: there is more to prepare
  std::string stop_reason_ = "the server stops";  // written before stopping_, by the worker's thread only
  std::shared_ptr<const MergeView> view_ = std::make_shared<MergeView>();
  std::thread thread_;
};

/// The result of a read from the store; while the store is unreachable, tries again until it is back or the server
/// stops.
template <class Read>
auto MergeWorker::read_patiently(const Read& read) -> decltype(read()) {
  auto answer = read();
  const auto piece = watch_.piece();
  bool waited = false;
  for (bool stops = false; !answer && !stops && store_.is_away(); answer = read()) {
    if (!waited) no_work();  // time spent waiting for the database does not count against the sessions
    waited = true;
    std::unique_lock lock(mutex_);
    stops = wake_.wait_for(lock, look_again_after, [&] { return stopping_; });
  }
  if (waited && piece) working_on(piece->a, piece->b);
  return answer;
}

}  // namespace headframe
