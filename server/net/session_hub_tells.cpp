// What robots are told without having asked: how they may send, and the transforms of their component.
#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/wire/limits.hpp"
#include "server/net/session_hub.hpp"

namespace headframe {
namespace {

constexpr std::size_t comfortable_page_bytes = 16384;  // two seconds of a link of 64 kbit/s, for which an ack may wait

/// Without the session that it was merged with.
v1::TransformSupport support_message(const PlacementSupport& support) {
  v1::TransformSupport message;
  message.set_probability(support.probability);
  message.set_merges(static_cast<std::uint32_t>(support.merges));
  message.set_shared_m(static_cast<float>(support.shared_m));
  message.set_confirmed(support.confirmed);
  message.set_deviation_m(static_cast<float>(support.deviation_m));
  message.set_deviation_rad(static_cast<float>(support.deviation_rad));
  return message;
}

}  // namespace

LinkPolicy SessionHub::policy() {
  constexpr auto good_for = std::chrono::milliseconds(50);  // every connection asks often
  const std::lock_guard made(policy_mutex_);
  const auto now = Clock::now();
  if (now - policy_made_ < good_for) return policy_;
  policy_made_ = now;
  LinkPolicy policy;
  const StoreLoad load = store_.load();
  const bool was_held = !policy_.hold.empty();
  if (!load.broken.empty())
    policy.hold =
        "the server can not write its database until it is mended and the server started anew: " + load.broken;
  else if (!load.waits_for.empty())
    policy.hold = "the server waits until it can write: " + load.waits_for;
  else if (load.queued_bytes > load.queue_bytes / (was_held ? 4 : 2))
    policy.hold = "the server's disk is slow: more waits to be written than is good";
  if (const std::uint64_t budget = budget_bytes_per_s_; budget > 0) {
    const std::lock_guard lock(mutex_);
    const auto connected = std::count_if(sessions_.begin(), sessions_.end(),
                                         [](const auto& entry) { return !entry.second.link.expired(); });
    policy.bytes_per_s =
        std::max<std::uint64_t>(1, budget / std::max<std::uint64_t>(1, static_cast<std::uint64_t>(connected)));
  }
  if (policy.hold != policy_.hold) {
    if (policy.hold.empty())
      spdlog::info("robots may send again");
    else
      spdlog::error("robots are held, nothing is acknowledged: {}", policy.hold);
  }
  policy_ = policy;
  return policy;
}

LinkPolicy SessionHub::policy_of(SessionId session) {
  LinkPolicy told = policy();
  const std::lock_guard lock(mutex_);
  if (carrier(session).split_waits) store_split(last_part(session));
  told.cut = cut_text_for_robot(session);
  const Session& known = carrier(session);
  const auto own = rates_bytes_per_s_.find(known.record.key.robot);
  if (own != rates_bytes_per_s_.end() && (told.bytes_per_s == 0 || own->second < told.bytes_per_s))
    told.bytes_per_s = own->second;
  return told;
}

/// The next tick of its connection tells the robot.
void SessionHub::tell_cut(SessionId session, const SessionCut& cut) {
  const std::lock_guard lock(mutex_);
  sessions_.at(session).cut = cut;
  if (cut.for_good) split(session);
}

void SessionHub::set_rate(const std::string& robot, std::uint64_t bytes_per_s) {
  const std::lock_guard lock(mutex_);
  if (bytes_per_s > 0)
    rates_bytes_per_s_[robot] = bytes_per_s;
  else
    rates_bytes_per_s_.erase(robot);
}

void SessionHub::set_robot_site(const std::string& robot, const std::string& site,
                                std::function<void(const Result<void>&)> done) {
  auto named = check_name("robot", robot);
  if (named && !site.empty()) named = check_name("site", site);
  if (!named) return done(failure(ErrorCode::invalid_argument, named.error().message));
  {
    const std::lock_guard lock(mutex_);
    if (!site.empty() && !robot_sites_.contains(robot) && robot_sites_.size() >= most_robot_sites)
      named = failure(ErrorCode::refused, std::to_string(most_robot_sites) + " robots have a site already");
  }
  if (!named) return done(named);
  store_.write(PutRobotSite{robot, site}, [this, robot, site, done = std::move(done)](const Result<void>& durable) {
    if (durable) {
      const std::lock_guard lock(mutex_);
      site.empty() ? (void)robot_sites_.erase(robot) : (void)robot_sites_.insert_or_assign(robot, site);
    }
    done(durable);
  });
}

std::map<std::string, std::string> SessionHub::robot_sites() const {
  const std::lock_guard lock(mutex_);
  return robot_sites_;
}

void SessionHub::set_site(SessionId session, const std::string& site) {
  const std::lock_guard lock(mutex_);
  sessions_.at(session).record.site = site;
}

/// Under the lock.
v1::TransformUpdate SessionHub::update_of(const Component& component, const Told& told) const {
  v1::TransformUpdate update;
  update.set_revision(atlas_.revision);
  update.set_component(static_cast<std::uint64_t>(component.id));
  const auto key_of = [&](SessionId id) { return to_proto(key_for(told.part, id)); };
  *update.mutable_anchor() = key_of(component.id);
  for (const Placement& placement : component.placements) {
    auto& transform = *update.add_sessions();
    *transform.mutable_session() = key_of(placement.session);
    *transform.mutable_t_component_session() = to_proto(placement.T_component_session);
    const PlacementSupport* support = told.supports ? support_in(component, placement.session) : nullptr;
    if (support) *transform.mutable_support() = support_message(*support);
    if (support && support->merged_with != 0)
      *transform.mutable_support()->mutable_merged_with() = key_of(support->merged_with);
  }
  for (const auto& [revision, w] : withdrawn_) {
    if (!placement_in(component, w.a) && !placement_in(component, w.b)) continue;
    auto& merge = *update.add_withdrawn();
    merge.set_revision(revision);
    *merge.mutable_a() = key_of(w.a);
    *merge.mutable_b() = key_of(w.b);
    merge.set_reason(w.reason);
  }
  if (told.provisional)
    for (const ProvisionalPlacement& placement : component.provisional) {
      auto& transform = *update.add_provisional();
      *transform.mutable_session() = key_of(placement.session);
      *transform.mutable_t_component_session() = to_proto(placement.T_component_session);
      transform.set_probability(placement.probability);
      transform.set_awaited_m(placement.awaited_m);
    }
  return update;
}

/// Under the lock. A robot that takes no pages, of a component that does not fit a frame, is told of itself and of the
/// anchor.
SessionHub::PagesPtr SessionHub::pages_for(SessionId receiver, const Component& component, MadePages& made) const {
  const Session& session = sessions_.at(receiver);
  const std::size_t page_bytes = session.takes_pages ? comfortable_page_bytes : limits::frame_bytes;
  const Told told{session.wants_provisional, session.takes_supports, session.takes_pages,
                  session.whole == 0 ? 0 : receiver};
  PagesPtr& pages = made[told];
  if (!pages) pages = std::make_shared<const TransformPages>(transform_pages(update_of(component, told), page_bytes));
  if (session.takes_pages || pages->size() == 1) return pages;
  Component part{component.id, {}, {}, component.supports};
  for (const Placement& placement : component.placements)
    if (placement.session == receiver || placement.session == component.id) part.placements.push_back(placement);
  return std::make_shared<const TransformPages>(
      transform_pages(update_of(part, {false, told.supports, false, told.part}), page_bytes));
}

/// Under the lock. Null: the session has never been merged, and nothing that its robot asks for is provisional. What
/// was told before a part began means nothing there.
SessionHub::PagesPtr SessionHub::transform_of(SessionId session) const {
  MadePages made;
  const bool provisional = sessions_.at(session).wants_provisional;
  for (const Component& component : atlas_.components)
    if (placement_in(component, session) &&
        (told_.contains(session) || (provisional && !component.provisional.empty())))
      return pages_for(session, component, made);
  if (sessions_.at(session).whole == 0 || !told_.contains(session)) return nullptr;
  return pages_for(session, Component{session, {{session, Pose::Identity()}}}, made);
}

/// Under the lock: for the connected robots of the component, or for those alone that ask for what is provisional.
void SessionHub::add_updates(const Component& component, bool all, Updates& updates) const {
  MadePages made;
  for (const Placement& placement : component.placements) {
    const Session& session = sessions_.at(placement.session);
    auto robot = session.link.lock();
    if (!robot || (!all && !session.wants_provisional)) continue;
    updates.emplace_back(std::move(robot), pages_for(placement.session, component, made));
  }
}

void SessionHub::publish(const Atlas& atlas, const std::vector<Component>& changed,
                         const std::vector<Withdrawal>& withdrawn) {
  Updates updates;
  {
    const std::lock_guard lock(mutex_);
    atlas_ = atlas;
    for (const Withdrawal& w : withdrawn) withdrawn_.emplace_back(atlas.revision, w);
    while (withdrawn_.size() > most_withdrawn) withdrawn_.pop_front();
    for (const Component& component : changed) {
      for (const Placement& placement : component.placements) told_.insert(placement.session);
      add_updates(component, true, updates);
    }
  }
  desk_.changed();
  for (const auto& [robot, pages] : updates) robot->update_transform(pages);
}

void SessionHub::tell_provisional(const Atlas& atlas, const std::vector<Component>& changed) {
  Updates updates;
  {
    const std::lock_guard lock(mutex_);
    atlas_ = atlas;
    for (const Component& component : changed) add_updates(component, false, updates);
  }
  for (const auto& [robot, pages] : updates) robot->update_transform(pages);
}

}  // namespace headframe
