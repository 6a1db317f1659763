#include "server/merge_worker/merge_schedule.hpp"

#include <algorithm>
#include <array>

namespace headframe {

std::string_view to_string(Trigger trigger) {
  constexpr std::array<std::string_view, 11> names{"link",     "travelled", "request",  "goodbye", "command", "restart",
                                                   "junction", "rest",      "localize", "awaited", "poses"};
  return names.at(static_cast<std::size_t>(trigger));
}

void MergeSchedule::enqueue(const Attempt& attempt) {
  const auto same = [&](const Attempt& a) { return a.session == attempt.session; };
  if (std::any_of(queue_.begin(), queue_.end(), same)) return;
  used_s(attempt.session) = std::max(used_s(attempt.session), turn_s_);
  queue_.push_back(attempt);
}

std::string MergeSchedule::robot_of(SessionId session) const {
  const auto robot = robots_.find(session);
  return robot == robots_.end() ? std::to_string(session) : robot->second;
}

double& MergeSchedule::used_s(SessionId session) { return used_s_[robot_of(session)]; }

void MergeSchedule::spent(SessionId session, double seconds) { used_s(session) += seconds; }

void MergeSchedule::trigger(SessionId session, Trigger trigger, Time now) { enqueue({session, trigger, now}); }

void MergeSchedule::travelled(SessionId session, double metres, Time now) {
  double& since_try_m = travelled_m_[session];
  since_try_m += metres;
  if (since_try_m >= asked_m && ask_where_.contains(session)) trigger(session, Trigger::localize, now);
  if (since_try_m >= config_.travelled_m) trigger(session, Trigger::travelled, now);
  if (since_try_m >= config_.junction_m && at_junction_.contains(session)) trigger(session, Trigger::junction, now);
}

void MergeSchedule::junction(SessionId session, Time now) {
  at_junction_.insert(session);
  travelled(session, 0, now);
}

void MergeSchedule::asks_where(SessionId session, bool asks, Time now) {
  if (!asks) {
    ask_where_.erase(session);
    return;
  }
  ask_where_.insert(session);
  trigger(session, Trigger::localize, now);
}

std::deque<MergeSchedule::Attempt>::iterator MergeSchedule::whose_turn() {
  const auto less_used = [&](const Attempt& a, const Attempt& b) { return used_s(a.session) < used_s(b.session); };
  const auto asks = [&](const Attempt& a) { return !a.leftover && ask_where_.contains(a.session); };
  const bool any_asks = !asker_was_last_ && std::any_of(queue_.begin(), queue_.end(), asks);
  asker_was_last_ = any_asks;
  if (!any_asks) return std::min_element(queue_.begin(), queue_.end(), less_used);
  return std::min_element(queue_.begin(), queue_.end(), [&](const Attempt& a, const Attempt& b) {
    return asks(a) != asks(b) ? asks(a) : less_used(a, b);
  });
}

std::optional<MergeSchedule::Attempt> MergeSchedule::next() {
  if (queue_.empty()) return std::nullopt;
  const auto first = whose_turn();
  const Attempt attempt = *first;
  queue_.erase(first);
  turn_s_ = used_s(attempt.session);
  travelled_m_[attempt.session] = 0;
  at_junction_.erase(attempt.session);
  return attempt;
}

void MergeSchedule::again(const Attempt& attempt) {
  Attempt rest = attempt;
  rest.leftover = true;
  enqueue(rest);
}

MergeSchedule::Time MergeSchedule::after(Time now, double seconds) {
  return now + std::chrono::duration_cast<Time::duration>(std::chrono::duration<double>(seconds));
}

void MergeSchedule::grows(SessionId session, Time now) {
  rests_at_[session] = after(now, config_.rest_s);
  if (awaited_until_.contains(session)) return;
  Time& first = first_grew_.try_emplace(robot_of(session), now).first->second;
  if (now - first >= std::chrono::hours(1)) first = now;
  awaited_until_[session] = after(first, config_.awaited_s);
}

void MergeSchedule::ended(SessionId session) {
  rests_at_.erase(session);
  awaited_until_.erase(session);
}

void MergeSchedule::asks(SessionId session, Time now) {
  if (const auto it = rests_at_.find(session); it != rests_at_.end())
    it->second = std::min(it->second, after(now, config_.asked_rest_s));
}

std::vector<SessionId> MergeSchedule::come_to_rest(Time now) {
  std::vector<SessionId> out;
  for (const auto& [session, time] : rests_at_)
    if (time <= now) out.push_back(session);
  for (const SessionId session : out) ended(session);
  return out;
}

std::vector<SessionId> MergeSchedule::waited_out(Time now) {
  std::vector<SessionId> out;
  for (auto& [session, until] : awaited_until_) {
    if (!until || *until > now) continue;
    until.reset();
    out.push_back(session);
  }
  return out;
}

std::vector<KeyframeRef> MergeSchedule::wait_for(Attempt attempt, const std::vector<KeyframeRef>& wanted, Time now) {
  std::vector<KeyframeRef> ask;
  if (wanted.empty() || ++attempt.round > most_rounds) return ask;
  std::set<KeyframeRef> missing;
  for (const KeyframeRef& cloud : wanted) {
    if (in_vain(cloud)) continue;
    missing.insert(cloud);
    if (!awaited_.insert(cloud).second) continue;
    ask.push_back(cloud);
    deadlines_[cloud.session] = after(now, config_.submap_s);
  }
  if (missing.empty()) {
    enqueue(attempt);
    return ask;
  }
  const auto same = [&](const Waiting& w) { return w.attempt.session == attempt.session; };
  const auto waiting = std::find_if(waiting_.begin(), waiting_.end(), same);
  if (waiting == waiting_.end())
    waiting_.push_back({attempt, std::move(missing)});
  else
    waiting->missing.merge(missing);
  return ask;
}

void MergeSchedule::settle(const KeyframeRef& cloud) {
  if (awaited_.erase(cloud) == 0) return;
  const auto next = awaited_.lower_bound({cloud.session, 0});
  if (next == awaited_.end() || next->session != cloud.session) deadlines_.erase(cloud.session);
  for (Waiting& w : waiting_)
    if (w.missing.erase(cloud) > 0 && w.missing.empty()) enqueue(w.attempt);
  std::erase_if(waiting_, [](const Waiting& w) { return w.missing.empty(); });
}

void MergeSchedule::cloud_came(const KeyframeRef& cloud, Time now) {
  in_vain_.erase(cloud);
  settle(cloud);
  if (const auto it = deadlines_.find(cloud.session); it != deadlines_.end()) it->second = after(now, config_.submap_s);
}

void MergeSchedule::cloud_will_not_come(const KeyframeRef& cloud) {
  in_vain_.insert(cloud);
  settle(cloud);
}

void MergeSchedule::robot_came(SessionId session) {
  std::erase_if(in_vain_, [&](const KeyframeRef& cloud) { return cloud.session == session; });
}

void MergeSchedule::give_up(SessionId session) {
  std::vector<KeyframeRef> owed;
  for (const KeyframeRef& cloud : awaited_)
    if (cloud.session == session) owed.push_back(cloud);
  for (const KeyframeRef& cloud : owed) cloud_will_not_come(cloud);
}

void MergeSchedule::robot_left(SessionId session) { give_up(session); }

void MergeSchedule::tick(Time now) {
  std::vector<SessionId> late;
  for (const auto& [session, time] : deadlines_)
    if (time <= now) late.push_back(session);
  for (const SessionId session : late) give_up(session);
}

std::optional<MergeSchedule::Time> MergeSchedule::next_deadline() const {
  std::optional<Time> first;
  for (const auto* times : {&deadlines_, &rests_at_})
    for (const auto& [session, time] : *times) first = first ? std::min(*first, time) : time;
  for (const auto& [session, until] : awaited_until_)
    if (until) first = first ? std::min(*first, *until) : *until;
  return first;
}

}  // namespace headframe
