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

/// What the worker knows, as of the last durable revision.
struct MergeView {
  struct Session {
    double distance_m = 0;
    double trigger_to_transform_ms = -1;  // from the trigger of the attempt that placed it; -1: none has
    std::string why_aside = {};           // it is not merged, and why; empty: it is
    bool deleted = false;
    bool archived = false, frozen = false;
    std::string site = {};
  };
  Atlas atlas;  // every session is in it that is neither archived nor deleted
  std::vector<Alignment> alignments;
  std::map<SessionId, Session> sessions;
  Corrections corrections = {};  // where the pose graph puts keyframes
};

/// The one thread that owns the pipeline. It feeds durable keyframes from the store, tries sessions as the schedule
/// says, stores what an attempt changed, and only then publishes it. One attempt at a time; a full disk holds merging
/// up and nothing else; a database that can not be written ends it. Thread safe but for restore() and start().
class MergeWorker : public MergeNews, private CloudSource {
 public:
  /// mark: where it notes what it works on; none: a death is blamed on nobody.
  MergeWorker(std::unique_ptr<Pipeline> pipeline, Store& store, const ScheduleConfig& config,
              std::optional<WorkMark> mark = std::nullopt);
  ~MergeWorker() override;  // stop()

  /// Reads what the store holds; once, before start(). The atlas is there at once, as it was published last; the
  /// keyframes are read by the worker, and pending() says so. Sessions with keyframes that no attempt has seen are then
  /// tried.
  Result<void> restore();
  void start(Robots& robots);
  /// Waits for the attempt that is running; what is queued is found again by restore().
  void stop();

  void session_added(SessionId session, const NewSession& added) override;
  void keyframes_durable(SessionId session, std::uint64_t sequence) override;
  void poses_durable(SessionId session) override;
  void cloud_durable(const KeyframeRef& cloud) override;
  void clouds_unavailable(SessionId session, const std::vector<std::uint64_t>& sequences) override;
  /// They were deleted so that others find room: nobody is asked for them again.
  void clouds_let_go(SessionId session, const std::vector<std::uint64_t>& sequences);
  void robot_came(SessionId session, bool answers) override;
  void robot_left(SessionId session) override;
  void trigger(SessionId session, Trigger trigger) override;
  void asks_where(SessionId session, bool asks) override;

  /// Queues the operator's decision; `done` runs once: on the worker's thread when it is durable and the robots were
  /// told, or with a failure. unavailable: too many wait already, or the server stops; and as MergePipeline::decide.
  void decide(AlignmentId alignment, Decision decision, std::function<void(const Result<void>&)> done);

  /// Judges a placement that the operator made roughly (MergePipeline::place). `done` as decide()'s; what it asks of
  /// robots is asked also when it fails.
  void place(SessionId a, SessionId b, const Pose& T_a_b, std::function<void(const Result<HandPlacement>&)> done);

  /// Makes the session's frame that of its component; `done` as decide()'s. not_found: no such session.
  void anchor(SessionId session, std::function<void(const Result<void>&)> done);

  /// Asks the session's robot for all its clouds that are not here; `done` runs once with how many. not_found: no such
  /// session; refused: its robot is away, or sends no clouds.
  void request_clouds(SessionId session, std::function<void(const Result<std::size_t>&)> done);

  /// The session is not merged any more, from now on and after a restart; what is stored of it stays. `done` as
  /// decide()'s. not_found: no such session.
  void set_aside(SessionId session, const std::string& why, std::function<void(const Result<void>&)> done);
  /// It is merged again. refused: it is not set aside.
  void release(SessionId session, std::function<void(const Result<void>&)> done);
  /// Set aside, and all that is stored of it is deleted, for good.
  void remove(SessionId session, std::function<void(const Result<void>&)> done);
  /// archived: the session is kept and left out of everything, until it is said otherwise; it comes back as it was.
  /// `done` as decide()'s; not_found: no such session; refused: it is so already.
  void archive(SessionId session, bool archived, std::function<void(const Result<void>&)> done);
  /// frozen: nothing moves it any more (MergePipeline::freeze); until it is said otherwise. `done` as archive()'s;
  /// refused also: it is archived or set aside.
  void freeze(SessionId session, bool frozen, std::function<void(const Result<void>&)> done);

  /// The session was driven at this site: it is merged with those there alone. `done` as archive()'s.
  void set_site(SessionId session, const std::string& site, std::function<void(const Result<void>&)> done);

  Pending pending() const;
  /// What the operator asked for and the worker has not taken up.
  std::size_t waiting_orders() const;
  std::shared_ptr<const MergeView> view() const;
  /// What the worker works on at this moment; none: nothing.
  std::optional<WorkPiece> working_on_now() const { return watch_.piece(); }
  /// Why merging counts as stuck; empty: it does not.
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
    bool more_to_try = false;  // its last attempt has not looked at all that it could lie on
    std::optional<SessionLocalization> told_where = std::nullopt;  // since its robot asked; none: nothing
  };

  /// What the operator asks for: run once, on the worker's thread, or with why it can not be carried out.
  using Order = std::function<void(const Result<void>& admitted)>;
  static constexpr std::size_t most_orders = 64, most_unprepared = 4096;
  static constexpr auto look_again_after = std::chrono::milliseconds(200);  // for a store that is away

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
  Result<KeyframeCloud> load(const KeyframeRef& keyframe) override;
  void working_on(SessionId a, SessionId b) override;

  // The worker's thread only.
  std::unique_ptr<Pipeline> pipeline_;
  Store& store_;
  Robots* robots_ = nullptr;
  MergeSchedule schedule_;
  std::map<SessionId, Known> known_;
  std::deque<KeyframeRef> unprepared_;  // clouds that came; the newest most_unprepared of them
  std::map<SessionId, TroubleRecord> troubles_;
  std::set<SessionId> archived_, frozen_;
  std::optional<WorkMark> mark_;
  const double stuck_s_;
  WorkWatch watch_;  // any thread
  Atlas atlas_;      // as published last
  struct Stored {
    std::vector<SessionRecord> sessions;
    StoredMerge merge;
  };
  std::optional<Stored> stored_;  // not yet brought back
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
  Pending pending_;  // of the schedule, when the worker looked last
  MergeEffort effort_;
  bool busy_ = false, stopping_ = false;
  bool ahead_ = false;                            // the worker's thread only: there is more to prepare
  std::string stop_reason_ = "the server stops";  // written before stopping_ by the worker's thread alone
  std::shared_ptr<const MergeView> view_ = std::make_shared<MergeView>();
  std::thread thread_;
};

/// What was read; while the store is away it is read again and again, until it is back or the server stops.
template <class Read>
auto MergeWorker::read_patiently(const Read& read) -> decltype(read()) {
  auto answer = read();
  const auto piece = watch_.piece();
  bool waited = false;
  for (bool stops = false; !answer && !stops && store_.is_away(); answer = read()) {
    if (!waited) no_work();  // the database's time is not the sessions' fault
    waited = true;
    std::unique_lock lock(mutex_);
    stops = wake_.wait_for(lock, look_again_after, [&] { return stopping_; });
  }
  if (waited && piece) working_on(piece->a, piece->b);
  return answer;
}

}  // namespace headframe
