// What other threads tell the worker, and what they can see of it.
#include <algorithm>

#include "server/merge_worker/merge_worker.hpp"

namespace headframe {

template <class Change>
void MergeWorker::tell(SessionId session, Change change) {
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) return;  // nobody reads it
    change(mailbox_[session]);
  }
  wake_.notify_all();
}

void MergeWorker::session_added(SessionId session, const NewSession& added) {
  tell(session, [&](SessionNews& news) { news.added = added; });
}

void MergeWorker::keyframes_durable(SessionId session, std::uint64_t sequence) {
  tell(session, [&](SessionNews& news) { news.durable_keyframes = std::max(news.durable_keyframes, sequence); });
}

void MergeWorker::poses_durable(SessionId session) {
  tell(session, [&](SessionNews& news) { news.poses = true; });
}

void MergeWorker::cloud_durable(const KeyframeRef& cloud) {
  tell(cloud.session, [&](SessionNews& news) {
    news.clouds_came.insert(cloud.sequence);
    news.clouds_gone.erase(cloud.sequence);
  });
}

void MergeWorker::clouds_unavailable(SessionId session, const std::vector<std::uint64_t>& sequences) {
  tell(session, [&](SessionNews& news) {
    for (const std::uint64_t sequence : sequences)
      if (!news.clouds_came.contains(sequence)) news.clouds_gone.insert(sequence);
  });
}

void MergeWorker::clouds_let_go(SessionId session, const std::vector<std::uint64_t>& sequences) {
  tell(session, [&](SessionNews& news) { news.clouds_let_go.insert(sequences.begin(), sequences.end()); });
}

void MergeWorker::robot_came(SessionId session, bool answers) {
  tell(session, [&](SessionNews& news) { news.came = answers; });
}

void MergeWorker::robot_left(SessionId session) {
  tell(session, [&](SessionNews& news) {
    news.left = true;
    news.came.reset();
    news.asks_where.reset();
  });
}

void MergeWorker::asks_where(SessionId session, bool asks) {
  tell(session, [&](SessionNews& news) { news.asks_where = asks; });
}

void MergeWorker::trigger(SessionId session, Trigger trigger) {
  tell(session, [&](SessionNews& news) {
    news.ended |= trigger == Trigger::goodbye;
    news.asks |= trigger == Trigger::request;
    if (!news.trigger) news.trigger.emplace(trigger, std::chrono::steady_clock::now());
  });
}

void MergeWorker::give(Order order) {
  {
    std::unique_lock lock(mutex_);
    if (stopping_ || orders_.size() >= most_orders) {
      const std::string why = stopping_ ? stop_reason_ : "too many decisions are waiting; try again in a moment";
      lock.unlock();
      return order(failure(ErrorCode::unavailable, why));
    }
    orders_.push_back(std::move(order));
  }
  wake_.notify_all();
}

void MergeWorker::decide(AlignmentId alignment, Decision decision, std::function<void(const Result<void>&)> done) {
  give([this, alignment, decision, done = std::move(done)](const Result<void>& admitted) {
    done(admitted ? carry_out(alignment, decision) : admitted);
  });
}

void MergeWorker::place(SessionId a, SessionId b, const Pose& T_a_b,
                        std::function<void(const Result<HandPlacement>&)> done) {
  give([this, a, b, T_a_b, done = std::move(done)](const Result<void>& admitted) {
    done(admitted ? carry_out_placement(a, b, T_a_b) : tl::unexpected(admitted.error()));
  });
}

void MergeWorker::anchor(SessionId session, std::function<void(const Result<void>&)> done) {
  give([this, session, done = std::move(done)](const Result<void>& admitted) {
    done(admitted ? carry_out_anchor(session) : admitted);
  });
}

void MergeWorker::request_clouds(SessionId session, std::function<void(const Result<std::size_t>&)> done) {
  give([this, session, done = std::move(done)](const Result<void>& admitted) {
    done(admitted ? ask_for_clouds(session) : tl::unexpected(admitted.error()));
  });
}

std::size_t MergeWorker::waiting_orders() const {
  const std::lock_guard lock(mutex_);
  return orders_.size();
}

Pending MergeWorker::pending() const {
  const std::lock_guard lock(mutex_);
  Pending pending = pending_;
  pending.attempts += (busy_ ? 1 : 0) + orders_.size();
  for (const auto& [session, news] : mailbox_) {
    pending.attempts += news.trigger ? 1 : 0;
    pending.keyframes += 1;  // a lower bound; the worker will know the number when it looks
  }
  return pending;
}

MergeEffort MergeWorker::effort() const {
  const std::lock_guard lock(mutex_);
  return effort_;
}

std::shared_ptr<const MergeView> MergeWorker::view() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

std::vector<Component> changed_components(const Atlas& before, const Atlas& now) {
  std::map<SessionId, const Component*> was;
  for (const Component& component : before.components)
    for (const Placement& placement : component.placements) was[placement.session] = &component;
  const auto same = [](const Placement& p, const Placement& q) {
    return p.session == q.session && p.T_component_session.matrix() == q.T_component_session.matrix();
  };
  std::vector<Component> changed;
  for (const Component& component : now.components) {
    const auto it = was.find(component.id);
    const Component* old = it == was.end() ? nullptr : it->second;
    const auto& placements = component.placements;
    const bool alone = placements.size() == 1 && (!old || old->placements.size() == 1);
    const bool kept =
        old && std::equal(placements.begin(), placements.end(), old->placements.begin(), old->placements.end(), same);
    if (!alone && !kept) changed.push_back(component);
  }
  return changed;
}

std::vector<Component> changed_provisionals(const Atlas& before, const Atlas& now) {
  std::map<SessionId, const Component*> was;
  for (const Component& component : before.components) was[component.id] = &component;
  std::vector<Component> changed;
  for (const Component& component : now.components) {
    const auto it = was.find(component.id);
    const std::vector<ProvisionalPlacement> none, &old = it == was.end() ? none : it->second->provisional;
    if (component.provisional != old) changed.push_back(component);
  }
  return changed;
}

}  // namespace headframe
