#include "client/spooled_link.hpp"

#include <algorithm>
#include <utility>

#include "common/wire/capabilities.hpp"

namespace headframe {

using Lock = std::lock_guard<std::mutex>;

std::uint64_t SpooledLink::last_sequence() const {
  const Lock lock(mutex_);
  return spool_.last_sequence();
}

Result<Keyframe> SpooledLink::keyframe(std::uint64_t sequence) const {
  const Lock lock(mutex_);
  return spool_.keyframe(sequence);
}

std::uint64_t SpooledLink::last_pose_update() const {
  const Lock lock(mutex_);
  return spool_.pose_updates().last();
}

std::uint64_t SpooledLink::keyframes_at_update(std::uint64_t number) const {
  const Lock lock(mutex_);
  return spool_.pose_updates().keyframes_at(number);
}

Result<std::vector<KeyframePose>> SpooledLink::poses(std::uint64_t first, std::uint64_t last) const {
  const Lock lock(mutex_);
  return spool_.poses(first, last);
}

Result<void> SpooledLink::update_poses(std::vector<KeyframePose> poses) {
  const Lock lock(mutex_);
  return spool_.update_poses(std::move(poses));
}

bool SpooledLink::holds_cloud(std::uint64_t sequence) const {
  const Lock lock(mutex_);
  return spool_.holds_cloud(sequence);
}

std::uint64_t SpooledLink::next_held_cloud(std::uint64_t from) const {
  const Lock lock(mutex_);
  return spool_.next_held_cloud(from);
}

Result<std::string> SpooledLink::cloud(std::uint64_t sequence) const {
  const Lock lock(mutex_);
  return spool_.cloud(sequence);
}

std::optional<LiveState> SpooledLink::live() const {
  const Lock lock(mutex_);
  return live_;
}

void SpooledLink::say(const std::optional<LiveState>& state) {
  const Lock lock(mutex_);
  const auto before = std::exchange(live_, state);
  if (!live_ || live_->T_local_sensor || !before) return;
  live_->T_local_sensor = before->T_local_sensor;
  live_->stamp_s = before->stamp_s;
}

void SpooledLink::say_pose(double stamp_s, const Pose& T_local_sensor) {
  const Lock lock(mutex_);
  if (!live_) live_.emplace();
  live_->stamp_s = stamp_s;
  live_->T_local_sensor = T_local_sensor;
}

Result<void> SpooledLink::append(const Keyframe& keyframe, std::string_view encoded_cloud) {
  const Lock lock(mutex_);
  return spool_.append(keyframe, encoded_cloud);
}

void SpooledLink::on_event(const UplinkEvent& event) {
  if (const auto* t = std::get_if<Transforms>(&event)) return take(*t);
  if (const auto* l = std::get_if<Localization>(&event)) return hand_on(*l, &SpooledLink::on_localization_);
  if (const auto* o = std::get_if<Trajectories>(&event)) return hand_on(*o, &SpooledLink::on_trajectories_);
  if (const auto* c = std::get_if<Coverage>(&event)) return hand_on(*c, &SpooledLink::on_coverage_);
  if (const auto* m = std::get_if<MapAround>(&event)) return hand_on(*m, &SpooledLink::on_map_);
  const Lock lock(mutex_);
  Result<void> written;
  if (const auto* w = std::get_if<Welcomed>(&event)) {
    welcomed_ = true;
    server_capabilities_ = w->capabilities;
    durable_keyframes_ = durable_update_ = 0;
    link_error_.clear();
    hold_.clear();
    cut_.clear();
    server_bytes_per_s_ = 0;
    written = spool_.run_welcomed();
  } else if (const auto* p = std::get_if<PolicyTold>(&event)) {
    hold_ = p->hold;
    cut_ = p->cut;
    server_bytes_per_s_ = p->bytes_per_s;
  } else if (const auto* k = std::get_if<KeyframesDurable>(&event)) {
    durable_keyframes_ = std::max(durable_keyframes_, k->up_to);
    written = spool_.acknowledge_keyframes(k->up_to);
  } else if (const auto* u = std::get_if<PosesDurable>(&event)) {
    durable_update_ = std::max(durable_update_, u->up_to_update);
    written = spool_.acknowledge_poses(u->up_to_update);
  } else if (const auto* c = std::get_if<CloudsDurable>(&event)) {
    for (auto s = spool_.next_held_cloud(c->first); s != 0 && s <= c->last; s = spool_.next_held_cloud(s + 1))
      if (auto ok = spool_.acknowledge_cloud(s); !ok) written = ok;
  } else if (const auto* d = std::get_if<CloudUnreadable>(&event)) {
    spool_.drop_cloud(d->sequence);
    cloud_error_ = d->error.message;
  } else if (const auto* r = std::get_if<CloudRefused>(&event)) {
    spool_.drop_cloud(r->sequence);
    ++refused_clouds_;
    cloud_error_ = "cloud of keyframe " + std::to_string(r->sequence) + " was refused: " + r->reason;
  } else if (const auto* e = std::get_if<LinkEnded>(&event)) {
    link_error_ = e->error.message;
    refused_ = e->permanent;
  }
  if (!written) link_error_ = written.error().message;  // harmless: it is requested again after a restart
  changed_.notify_all();
}

void SpooledLink::take(const Transforms& transforms) {
  std::function<void(const Transforms&)> callback;
  {
    const Lock lock(mutex_);
    const bool known = transforms_ && transforms_->revision == transforms.revision &&
                       transforms_->component == transforms.component &&
                       transforms_->provisional == transforms.provisional;
    transforms_ = transforms;
    if (!known) callback = on_transform_;
  }
  if (callback) callback(transforms);
}

/// Calls the callback that was set last, without holding the lock.
template <class Told>
void SpooledLink::hand_on(const Told& told, std::function<void(const Told&)> SpooledLink::*set) {
  std::function<void(const Told&)> callback;
  {
    const Lock lock(mutex_);
    callback = this->*set;
  }
  if (callback) callback(told);
}

void SpooledLink::on_localization(const std::function<void(const Localization&)>& callback) {
  const Lock lock(mutex_);
  on_localization_ = callback;
}

void SpooledLink::on_trajectories(const std::function<void(const Trajectories&)>& callback) {
  const Lock lock(mutex_);
  on_trajectories_ = callback;
}

void SpooledLink::on_coverage(const std::function<void(const Coverage&)>& callback) {
  const Lock lock(mutex_);
  on_coverage_ = callback;
}

void SpooledLink::on_map(const std::function<void(const MapAround&)>& callback) {
  const Lock lock(mutex_);
  on_map_ = callback;
}

void SpooledLink::on_transform(const std::function<void(const Transforms&)>& callback) {
  std::optional<Transforms> known;
  {
    const Lock lock(mutex_);
    if (callback) known = transforms_;
    on_transform_ = callback;
  }
  if (known) callback(*known);
}

std::optional<Transforms> SpooledLink::transforms() const {
  const Lock lock(mutex_);
  return transforms_;
}

Progress SpooledLink::progress() const {
  const Lock lock(mutex_);
  Progress p;
  p.keyframes = spool_.last_sequence();
  p.keyframes_acknowledged = welcomed_ ? durable_keyframes_ : spool_.acknowledged_keyframes();
  p.pose_updates = spool_.pose_updates().last();
  p.pose_updates_acknowledged = welcomed_ ? durable_update_ : spool_.pose_updates().acknowledged();
  p.pose_updates_unsupported = welcomed_ && !takes_poses() && p.pose_updates > 0;
  p.clouds_waiting = spool_.held_clouds();
  p.clouds_acknowledged = spool_.acknowledged_clouds();
  p.clouds_dropped = spool_.dropped_clouds();
  p.clouds_refused = refused_clouds_;
  p.cloud_error = cloud_error_;
  p.refused = refused_;
  p.server_capabilities = server_capabilities_;
  p.hold = hold_;
  p.cut = cut_;
  p.server_bytes_per_s = server_bytes_per_s_;
  p.link_error = link_error_;
  return p;
}

/// Whether the server of the present or last connection supports them. Call under the lock.
bool SpooledLink::takes_poses() const {
  return std::find(server_capabilities_.begin(), server_capabilities_.end(), poses_capability) !=
         server_capabilities_.end();
}

bool SpooledLink::all_acknowledged() const {
  const Lock lock(mutex_);
  return welcomed_ && durable_keyframes_ == spool_.last_sequence() &&
         (durable_update_ == spool_.pose_updates().last() || !takes_poses()) &&
         (spool_.identity().clouds != CloudPolicy::all || spool_.held_clouds() == 0);
}

void SpooledLink::wait(std::chrono::milliseconds most) const {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait_for(lock, most);
}

}  // namespace headframe
