#include "server/merge_worker/merge_worker.hpp"

#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>

#include "server/support/parallel.hpp"
#include "server/support/stopwatch.hpp"

namespace headframe {
namespace {

constexpr int merge_nice = 10;

}  // namespace

MergeWorker::MergeWorker(std::unique_ptr<Pipeline> pipeline, Store& store, const ScheduleConfig& config,
                         std::optional<WorkMark> mark)
    : pipeline_(std::move(pipeline)),
      store_(store),
      schedule_(config),
      mark_(std::move(mark)),
      stuck_s_(config.stuck_s),
      watch_(config.budget_s) {}

MergeWorker::~MergeWorker() { stop(); }

void MergeWorker::start(Robots& robots) {
  robots_ = &robots;
  thread_ = std::thread([this] { run(); });
}

void MergeWorker::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    watch_.stop();
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
  turn_away();
}

/// Fails the orders that will not be carried out.
void MergeWorker::turn_away() {
  std::unique_lock lock(mutex_);
  const std::vector<Order> late = std::exchange(orders_, {});
  const std::string why = stop_reason_;
  lock.unlock();
  for (const Order& order : late) order(failure(ErrorCode::unavailable, why));
}

void MergeWorker::run() {
  // Robots wait for acknowledgements, but nobody for merges: this thread, and those it starts, run at low priority. If
  // the system refuses that, nothing else changes.
  (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), merge_nice);
  const Cancellable cancellable(watch_.flag());
  Mailbox news;
  std::vector<Order> orders;
  try {
    bring_back();
    while (wait_for_news(news, orders)) {
      for (const auto& [session, what] : news) {
        working_on(session, session);
        take(session, what);
      }
      no_work();
      if (!news.empty()) update_view();
      for (const Order& order : orders) order({});
      tell_where(!orders.empty());
      schedule_.tick(Clock::now());
      for (const SessionId session : schedule_.come_to_rest(Clock::now())) come_to_rest(session);
      for (const SessionId session : schedule_.waited_out(Clock::now())) await_no_more(session);
      const auto next = schedule_.next();
      if (next) attempt(*next);
      if (next) tell_where(true);
      ahead_ = next || prepare_ahead();
      no_work();
      rest();
    }
  } catch (const Cancelled&) {
    spdlog::info("the server stops in the middle of an attempt; it is made anew after the next start");
  }
  no_work();
  turn_away();
}

/// Returns false if the work threw or used up its budget; then its sessions are blamed.
bool MergeWorker::tried(const char* what, const std::function<void()>& work) {
  try {
    work();
    return true;
  } catch (const Cancelled&) {
    if (watch_.stopped()) throw;
    spdlog::error("{} was given up: {}", what, why_stuck(watch_.piece(), Clock::now(), 0));
  } catch (const std::exception& e) {
    spdlog::error("{} failed: {}", what, e.what());
  }
  work_failed();
  return false;
}

/// While nothing waits: computes one piece of what the next attempts will need, so that they only have to register.
/// Returns false if nothing is left.
bool MergeWorker::prepare_ahead() {
  if (!unprepared_.empty()) {
    const KeyframeRef cloud = unprepared_.front();
    unprepared_.pop_front();
    working_on(cloud.session, cloud.session);
    if (!is_aside(cloud.session)) (void)tried("preparing a cloud", [&] { pipeline_->prepare_cloud(cloud, *this); });
    return true;
  }
  bool more = false;
  (void)tried("preparing for merges", [&] { more = pipeline_->prepare_ahead(*this); });
  return more;
}

/// Sleeps until there is something to do; returns false to stop.
bool MergeWorker::wait_for_news(Mailbox& news, std::vector<Order>& orders) {
  std::unique_lock lock(mutex_);
  const auto asked = [&] { return !mailbox_.empty() || !orders_.empty() || pending_.attempts > 0; };
  const auto due = [&] { return stopping_ || ahead_ || asked(); };
  if (const auto deadline = schedule_.next_deadline())
    wake_.wait_until(lock, *deadline, due);
  else
    wake_.wait(lock, due);
  if (stopping_) return false;
  busy_ = !ahead_ || asked();
  news = std::exchange(mailbox_, {});
  orders = std::exchange(orders_, {});
  return true;
}

void MergeWorker::rest() {
  const std::lock_guard lock(mutex_);
  pending_.attempts = schedule_.queued();
  pending_.awaited_submaps = schedule_.awaited();
  busy_ = false;
}

void MergeWorker::take(SessionId session, const SessionNews& news) {
  const auto now = Clock::now();
  if (is_aside(session)) {
    if (const auto found = known_.find(session); found != known_.end())
      found->second.answers = news.came.value_or(!news.left && found->second.answers);
    if (news.left || news.asks_where) take_question_aside(session, news.asks_where.value_or(false));
    return;
  }
  if (news.added) {
    schedule_.belongs(session, news.added->robot);
    pipeline_->add_session(session, news.added->family, news.added->site);
    if (!known_.contains(session)) known_[session].site = news.added->site;
  }
  Known& known = known_[session];
  if (news.poses) take_in_poses(session);
  if (news.durable_keyframes > known.keyframes) {
    feed(session, true, news.durable_keyframes);  // not those stored since, as new poses may come between
    schedule_.grows(session, now);
  }
  for (const std::uint64_t sequence : news.clouds_came) {
    known.stored.insert(sequence);
    schedule_.cloud_came({session, sequence}, now);
    unprepared_.push_back({session, sequence});
    if (unprepared_.size() > most_unprepared) unprepared_.pop_front();
  }
  for (const std::uint64_t sequence : news.clouds_let_go) {
    known.stored.erase(sequence);
    known.let_go.insert(sequence);
  }
  for (const std::uint64_t sequence : news.clouds_gone) schedule_.cloud_will_not_come({session, sequence});
  if (news.left) {
    known.answers = false;
    take_question(session, false);
    schedule_.robot_left(session);
  }
  if (news.came) {
    known.answers = *news.came;
    schedule_.robot_came(session);
  }
  if (news.asks_where) take_question(session, *news.asks_where);
  if (news.asks) schedule_.asks(session, now);
  if (news.ended) {
    pipeline_->complete_session(session);
    schedule_.ended(session);
  }
  if (news.trigger && known.keyframes > 0) schedule_.trigger(session, news.trigger->first, news.trigger->second);
}

/// A session that has paused can no longer contradict a placement by driving on, unless it stands still because its
/// robot waits to be told where it is. If its robot drives on after all, it grows again.
void MergeWorker::come_to_rest(SessionId session) {
  if (is_aside(session) || known_[session].keyframes == 0 || known_[session].asks_where) return;
  pipeline_->complete_session(session);
  schedule_.trigger(session, Trigger::rest, Clock::now());
}

void MergeWorker::await_no_more(SessionId session) {
  if (is_aside(session)) return;
  pipeline_->await_no_more(session);
  schedule_.trigger(session, Trigger::awaited, Clock::now());
}

void MergeWorker::attempt(const MergeSchedule::Attempt& attempt) {
  if (is_aside(attempt.session)) return;
  AttemptReport report;
  const auto start = Clock::now();
  working_on(attempt.session, attempt.session);
  const bool went_well = tried("an attempt to merge", [&] { report = pipeline_->attempt(attempt.session, *this); });
  no_work();
  schedule_.spent(attempt.session, ms_since(start) / 1000);
  if (!went_well) return;
  attempt_went_well(attempt.session);
  const StageTimes& t = report.times;
  {
    const std::lock_guard lock(mutex_);
    ++effort_.attempts;
    effort_.stages += t;
  }
  spdlog::info(
      "attempt: session {} ({}), {:.0f} ms: hypotheses {:.0f}, sampling {:.0f}, registration {:.0f}, verification "
      "{:.0f}, atlas {:.0f}; {} alignments changed, {} clouds wanted{}",
      attempt.session, to_string(attempt.trigger), ms_since(start), t.hypotheses_ms, t.sampling_ms, t.registration_ms,
      t.verification_ms, t.atlas_ms, report.changed.size(), report.wanted.size(),
      report.unfinished ? ", unfinished" : "");
  known_[attempt.session].more_to_try = report.unfinished;
  PutMerge write;
  if (report.wanted.empty() && !report.unfinished) {
    write.attempted = attempt.session;
    write.attempted_keyframes = known_[attempt.session].keyframes;
    write.attempted_whole = report.whole;
  }
  if (!commit(std::move(write), report, &attempt)) return;  // the server stops
  request(schedule_.wait_for(attempt, report.wanted, Clock::now()));
  if (report.unfinished) schedule_.again(attempt);
}

Result<HandPlacement> MergeWorker::carry_out_placement(SessionId a, SessionId b, const Pose& T_a_b) {
  AttemptReport report;
  Result<HandPlacement> placed = failure(ErrorCode::internal, "judging the placement failed; the log says why");
  (void)tried("placing by hand", [&] { placed = pipeline_->place(a, b, T_a_b, *this, report); });
  no_work();
  if (placed && !commit({}, report, nullptr)) return failure(ErrorCode::unavailable, stop_reason_);
  request(report.wanted);
  if (placed)
    spdlog::info("the operator laid session {} on {}: {}, probability {:.2f}; {}", b, a,
                 to_string(placed->alignment.state), placed->alignment.evidence.probability,
                 placed->recorded ? "kept as a candidate" : "not kept");
  return placed;
}

void MergeWorker::update_view() {
  draft_.atlas = stored_ ? stored_->merge.atlas : pipeline_->atlas();
  draft_.alignments = stored_ ? stored_->merge.alignments : pipeline_->alignments();
  draft_.corrections = stored_ ? Corrections() : pipeline_->corrections();
  std::set<SessionId> placed;
  for (const Component& component : draft_.atlas.components)
    for (const Placement& placement : component.placements) placed.insert(placement.session);
  for (const auto& [session, known] : known_)
    if (!placed.contains(session) && !archived_.contains(session))
      draft_.atlas.components.push_back({session, {{session, Pose::Identity()}}});
  std::sort(draft_.atlas.components.begin(), draft_.atlas.components.end(),
            [](const Component& a, const Component& b) { return a.id < b.id; });
  for (const auto& [session, trouble] : troubles_) draft_.sessions[session];
  for (const auto& [session, known] : known_) draft_.sessions[session];
  for (auto& [session, shown] : draft_.sessions) {
    const auto trouble = troubles_.find(session);
    shown.why_aside = trouble == troubles_.end() ? std::string() : trouble->second.why_aside;
    shown.deleted = trouble != troubles_.end() && trouble->second.deleted;
    shown.archived = archived_.contains(session) && !shown.deleted;
    shown.frozen = frozen_.contains(session) && !shown.deleted;
    if (const auto known = known_.find(session); known != known_.end()) shown.site = known->second.site;
  }
  auto made = std::make_shared<const MergeView>(draft_);
  const std::lock_guard lock(mutex_);
  view_ = std::move(made);
}

}  // namespace headframe
