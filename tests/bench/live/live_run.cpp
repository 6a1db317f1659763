#include "tests/bench/live/live_run.hpp"

#include <algorithm>
#include <cmath>

#include "common/descriptor/family.hpp"

namespace headframe::bench {
namespace {

constexpr double answer_s = 0.5;        // from the request of clouds to their arrival
constexpr double attempt_each_s = 0.1;  // for each other session, and to prepare a place, on idle cores
constexpr double prepare_s = 0.02;
constexpr double speed_mps = 1;

FamilyId family() { return make_family(default_family_name).value()->id(); }

std::vector<double> path_to_m(const DrivenSession& driven) {
  std::vector<double> out;
  for (std::size_t i = 0; i < driven.keyframes.size(); ++i)
    out.push_back(i == 0 ? 0
                         : out.back() + (driven.keyframes[i].T_local_sensor.translation() -
                                         driven.keyframes[i - 1].T_local_sensor.translation())
                                            .norm());
  return out;
}

}  // namespace

LiveRun::LiveRun(const std::vector<const DrivenSession*>& present, const std::vector<const DrivenSession*>& driving,
                 const LiveConditions& conditions, Watch watch)
    : conditions_(conditions),
      watch_(std::move(watch)),
      pipeline_(std::make_unique<MergePipeline>(MergeConfig{})),
      schedule_(std::make_unique<MergeSchedule>(ScheduleConfig{})),
      rng_(conditions.seed) {
  for (const DrivenSession* driven : present) {
    const SessionId id = add(*driven);
    for (const Keyframe& k : driven->keyframes) came_.insert({id, k.sequence});
    while (sessions_.at(id).told < driven->keyframes.size()) tell_keyframe(id);
    say_goodbye(id);
    settle();
  }
  std::vector<const DrivenSession*> order = driving;
  std::rotate(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(conditions.seed % order.size()), order.end());
  double start_s = now_s_, longest_s = 0;
  for (const DrivenSession* driven : order) longest_s = std::max(longest_s, path_to_m(*driven).back() / speed_mps);
  longest_s /= conditions.rate;
  for (const DrivenSession* driven : order) {
    const bool last = driven == order.back();
    if (last && conditions.start == Start::last_joins_midway) start_s += longest_s / 2;
    plan_drive(add(*driven), start_s, last && conditions.loses_link);
    if (conditions.start == Start::one_after_another)
      start_s += path_to_m(*driven).back() / speed_mps / conditions.rate + 30;
  }
  if (conditions.restarts) at(now_s_ + longest_s * 2 / 3, [this] { restart(); });
}

SessionId LiveRun::add(const DrivenSession& driven) {
  const auto id = static_cast<SessionId>(sessions_.size() + 1);
  sessions_[id].driven = &driven;
  return id;
}

void LiveRun::plan_drive(SessionId id, double start_s, bool loses_link) {
  const DrivenSession& driven = *sessions_.at(id).driven;
  const std::vector<double> path = path_to_m(driven);
  const double per_m = 1 / speed_mps / conditions_.rate;
  const double lost_m = path.back() / 3, found_m = path.back() * 2 / 3;
  if (loses_link) {
    at(start_s + lost_m * per_m, [this, id] { lose_link(id); });
    at(start_s + found_m * per_m, [this, id] { find_link(id); });
  }
  for (const double m : path)
    at(start_s + (loses_link && m > lost_m ? std::max(m, found_m) : m) * per_m, [this, id] { tell_keyframe(id); });
  at(start_s + path.back() * per_m + 0.1, [this, id] { say_goodbye(id); });
}

void LiveRun::tell_keyframe(SessionId id) {
  LiveSession& session = sessions_.at(id);
  const Keyframe& keyframe = session.driven->keyframes[session.told];
  double metres = 0;
  if (session.told == 0) {
    pipeline_->add_session(id, family());
    session.connected = true;
  } else {
    metres = (keyframe.T_local_sensor.translation() -
              session.driven->keyframes[session.told - 1].T_local_sensor.translation())
                 .norm();
  }
  ++session.told;
  session.path_m += metres;
  pipeline_->add_keyframe(id, keyframe);
  schedule_->travelled(id, metres, time());
  if (keyframe.descriptor.place_class == PlaceClass::junction) schedule_->junction(id, time());
  if (conditions_.clouds == Clouds::at_once) pipeline_->prepare_cloud({id, keyframe.sequence}, *this);
}

void LiveRun::lose_link(SessionId id) {
  sessions_.at(id).connected = false;
  schedule_->robot_left(id);
}

void LiveRun::find_link(SessionId id) {
  sessions_.at(id).connected = true;
  schedule_->robot_came(id);
  schedule_->trigger(id, Trigger::link, time());
}

/// It stays connected, as headframe-replay does, as long as it is asked for clouds.
void LiveRun::say_goodbye(SessionId id) {
  sessions_.at(id).complete = true;
  pipeline_->complete_session(id);
  schedule_->trigger(id, Trigger::goodbye, time());
}

/// What was stored comes back; what was kept in memory alone does not.
void LiveRun::restart() {
  auto alignments = pipeline_->alignments();
  const auto revision = pipeline_->atlas().revision;
  pipeline_ = std::make_unique<MergePipeline>(MergeConfig{});
  schedule_ = std::make_unique<MergeSchedule>(ScheduleConfig{});
  for (const auto& [id, session] : sessions_) {
    if (session.told == 0) continue;
    pipeline_->add_session(id, family());
    for (std::size_t i = 0; i < session.told; ++i) pipeline_->add_keyframe(id, session.driven->keyframes[i]);
    if (session.complete) pipeline_->complete_session(id);
  }
  for (Alignment& alignment : alignments) alignment.objection.reset();
  pipeline_->restore(std::move(alignments), revision);
  for (const auto& [id, session] : sessions_) {  // as MergeWorker does
    if (session.told == session.tried && session.complete == session.tried_whole) continue;
    schedule_->trigger(id, Trigger::restart, time());
    pipeline_->await_attempt(id);
  }
}

void LiveRun::drive() { settle(); }

void LiveRun::ask_for_merges() {
  for (const auto& [id, session] : sessions_) schedule_->trigger(id, Trigger::command, time());
  settle();
}

void LiveRun::settle() {
  constexpr std::size_t most_attempts = 300;  // many times what it takes
  std::size_t before = attempts_;
  while (step()) {
    if (!events_.empty()) before = attempts_;
    if (attempts_ > before + most_attempts)
      throw std::runtime_error(
          "all robots have ended, and attempts go on without end: " + std::to_string(attempts_ - before) + " so far");
  }
}

/// As the merge worker goes round: news, an attempt, or some of what attempts will need.
bool LiveRun::step() {
  while (!events_.empty() && events_.begin()->first <= now_s_) {
    const auto what = std::move(events_.begin()->second);
    events_.erase(events_.begin());
    what();
  }
  schedule_->tick(time());
  if (const auto next = schedule_->next()) {
    attempt(*next);
    return true;
  }
  if (pipeline_->prepare_ahead(*this)) {
    now_s_ += effort_s(prepare_s);
    return true;
  }
  if (!events_.empty()) {
    now_s_ = events_.begin()->first;
    return true;
  }
  if (const auto deadline = schedule_->next_deadline()) {
    now_s_ = std::max(now_s_, std::chrono::duration<double>(deadline->time_since_epoch()).count() + 1e-3);
    return true;
  }
  return false;
}

void LiveRun::attempt(const MergeSchedule::Attempt& attempt) {
  ++attempts_;
  const AttemptReport report = pipeline_->attempt(attempt.session, *this);
  now_s_ += effort_s(attempt_each_s * static_cast<double>(sessions_.size() - 1));
  if (report.atlas_changed || !report.changed.empty()) watch_(*this);
  if (LiveSession& session = sessions_.at(attempt.session); report.wanted.empty() && !report.unfinished) {
    session.tried = session.told;
    session.tried_whole = report.whole;
  }
  request(schedule_->wait_for(attempt, report.wanted, time()));
  if (report.unfinished) schedule_->again(attempt);
}

void LiveRun::request(const std::vector<KeyframeRef>& clouds) {
  if (clouds.empty()) return;
  at(now_s_ + answer_s, [this, clouds] {
    for (const KeyframeRef& cloud : clouds) {
      if (!sessions_.at(cloud.session).connected) {
        schedule_->cloud_will_not_come(cloud);
        continue;
      }
      came_.insert(cloud);
      schedule_->cloud_came(cloud, time());
      pipeline_->prepare_cloud(cloud, *this);
    }
  });
}

double LiveRun::effort_s(double idle_s) { return idle_s * conditions_.slowness * std::exp(0.5 * rng_.normal()); }

MergeSchedule::Time LiveRun::time() const {
  return MergeSchedule::Time(
      std::chrono::duration_cast<MergeSchedule::Time::duration>(std::chrono::duration<double>(now_s_)));
}

CloudState LiveRun::state(const KeyframeRef& keyframe) const {
  const LiveSession& session = sessions_.at(keyframe.session);
  if (keyframe.sequence > session.told) return CloudState::unobtainable;
  if (conditions_.clouds == Clouds::at_once || came_.contains(keyframe)) return CloudState::stored;
  return session.connected && !schedule_->in_vain(keyframe) ? CloudState::obtainable : CloudState::unobtainable;
}

Result<CloudDecoder> LiveRun::load(const KeyframeRef& keyframe) {
  return [&cloud = sessions_.at(keyframe.session).driven->clouds.at(keyframe.sequence - 1)]() -> Result<KeyframeCloud> {
    return cloud;
  };
}

}  // namespace headframe::bench
