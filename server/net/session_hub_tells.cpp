// What robots are told without having asked: how they may send, and the transforms of their component.
#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/wire/limits.hpp"
#include "server/net/session_hub.hpp"

namespace headframe {

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
    policy.hold = "the server waits for its disk: " + load.waits_for;
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
  const auto own = rates_bytes_per_s_.find(sessions_.at(session).record.key.robot);
  if (own != rates_bytes_per_s_.end() && (told.bytes_per_s == 0 || own->second < told.bytes_per_s))
    told.bytes_per_s = own->second;
  return told;
}

void SessionHub::set_rate(const std::string& robot, std::uint64_t bytes_per_s) {
  const std::lock_guard lock(mutex_);
  if (bytes_per_s > 0)
    rates_bytes_per_s_[robot] = bytes_per_s;
  else
    rates_bytes_per_s_.erase(robot);
}

/// Under the lock. Null when it does not fit a frame.
std::shared_ptr<const std::string> SessionHub::update_of(const Component& component) const {
  v1::ServerMessage message;
  auto& update = *message.mutable_transform_update();
  update.set_revision(atlas_.revision);
  update.set_component(static_cast<std::uint64_t>(component.id));
  *update.mutable_anchor() = to_proto(sessions_.at(component.id).record.key);
  for (const Placement& placement : component.placements) {
    auto& transform = *update.add_sessions();
    *transform.mutable_session() = to_proto(sessions_.at(placement.session).record.key);
    *transform.mutable_t_component_session() = to_proto(placement.T_component_session);
  }
  auto payload = std::make_shared<const std::string>(message.SerializeAsString());
  if (payload->size() <= limits::frame_bytes) return payload;
  spdlog::error("component {} has {} sessions: its transform update does not fit a frame and is not sent", component.id,
                component.placements.size());
  return nullptr;
}

/// Under the lock. Null: the session has never been merged.
std::shared_ptr<const std::string> SessionHub::transform_of(SessionId session) const {
  if (!told_.contains(session)) return nullptr;
  for (const Component& component : atlas_.components)
    for (const Placement& placement : component.placements)
      if (placement.session == session) return update_of(component);
  return nullptr;
}

void SessionHub::publish(const Atlas& atlas, const std::vector<Component>& changed) {
  std::vector<std::pair<std::shared_ptr<RobotLink>, std::shared_ptr<const std::string>>> updates;
  {
    const std::lock_guard lock(mutex_);
    atlas_ = atlas;
    for (const Component& component : changed) {
      const auto payload = update_of(component);
      for (const Placement& placement : component.placements) {
        told_.insert(placement.session);
        if (auto robot = sessions_.at(placement.session).link.lock(); robot && payload)
          updates.emplace_back(std::move(robot), payload);
      }
    }
  }
  for (const auto& [robot, payload] : updates) robot->update_transform(payload);
}

}  // namespace headframe
