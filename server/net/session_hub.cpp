#include "server/net/session_hub.hpp"

#include <spdlog/spdlog.h>

#include <bit>
#include <random>

#include "server/atlas/support.hpp"

namespace headframe {
namespace {

constexpr std::size_t keyframe_bytes = 1024;  // of memory until it is on disk, about

/// Of maps that robots are told of; another in each run of the server, and never a small number.
std::uint64_t first_epoch() {
  std::random_device random;
  return (std::uint64_t{random()} << 32 | random()) | 1ULL << 63;
}

}  // namespace

SessionHub::SessionHub(Store& store, MergeNews& news, const RobotLimits& limits)
    : store_(store),
      news_(news),
      limits_(limits),
      quota_(limits),
      desk_(
          store, first_epoch(), [this](SessionId session) { return surroundings_of(session); },
          [this](SessionId session, SurroundingsKind kind, SurroundingsDesk::Payload payload) {
            if (const auto robot = link_of(session)) robot->tell_surroundings(kind, std::move(payload));
          }) {}

Result<void> SessionHub::restore() {
  auto sessions = store_.sessions();
  if (!sessions) return tl::unexpected(sessions.error());
  auto merge = store_.merge();
  if (!merge) return tl::unexpected(merge.error());
  const auto troubles = store_.troubles();
  if (!troubles) return tl::unexpected(troubles.error());
  auto sites = store_.robot_sites();
  if (!sites) return tl::unexpected(sites.error());
  const std::lock_guard lock(mutex_);
  robot_sites_ = std::move(*sites);
  for (const SessionRecord& record : *sessions) {
    auto clouds = store_.cloud_sequences(record.id);
    if (!clouds) return tl::unexpected(clouds.error());
    const auto gone = store_.let_go(record.id);
    if (!gone) return tl::unexpected(gone.error());
    auto keyframes = store_.last_keyframe(record.id);
    if (!keyframes) return tl::unexpected(keyframes.error());
    Session& session = sessions_[record.id];
    session.record = record;
    session.keyframes = *keyframes;
    session.clouds = {clouds->begin(), clouds->end()};
    session.let_go = {gone->begin(), gone->end()};
    session.clouds.insert(gone->begin(), gone->end());
    ids_[record.key] = record.id;
  }
  for (const TroubleRecord& trouble : *troubles) sessions_[trouble.session].deleted = trouble.deleted;
  atlas_ = std::move(merge->atlas);
  add_supports(atlas_, merge->alignments);
  for (const Component& component : atlas_.components)
    for (const Placement& placement : component.placements)
      if (component.placements.size() > 1) told_.insert(placement.session);
  for (const Alignment& alignment : merge->alignments)
    if (alignment.state == AlignmentState::retracted) told_.insert({alignment.a, alignment.b});
  find_parts();
  return {};
}

std::uint64_t SessionHub::durable_keyframes(SessionId session) const {
  const std::lock_guard lock(mutex_);
  return durable_of(session).keyframes;
}

std::size_t SessionHub::stored_bytes(const RobotEvent& event) {
  if (std::holds_alternative<KeyframeReceived>(event)) return keyframe_bytes;
  if (const auto* update = std::get_if<PosesReceived>(&event))
    return update->poses.size() * sizeof(KeyframePose) + keyframe_bytes;
  if (const auto* cloud = std::get_if<CloudReceived>(&event)) return cloud->encoded.size() + keyframe_bytes;
  return 0;
}

void SessionHub::work_for(SessionId session, FairPool::Work work) {
  std::string robot;
  {
    const std::lock_guard lock(mutex_);
    robot = sessions_.at(session).record.key.robot;
  }
  decoding_.submit(robot, std::move(work));
}

void SessionHub::take(SessionId session, RobotEvent event, const std::shared_ptr<RobotLink>& link) {
  const std::size_t bytes = stored_bytes(event);
  if (auto* keyframe = std::get_if<KeyframeReceived>(&event)) handle(session, std::move(*keyframe), link, bytes);
  if (const auto* update = std::get_if<PosesReceived>(&event)) handle(session, *update, link, bytes);
  if (auto* cloud = std::get_if<CloudReceived>(&event)) handle(session, std::move(*cloud), link, bytes);
  if (const auto* refused = std::get_if<CloudRefused>(&event)) note_refusal(session, *refused);
  if (const auto* gone = std::get_if<CloudsUnavailable>(&event)) tell_unavailable(session, gone->sequences);
  if (const auto* goodbye = std::get_if<GoodbyeReceived>(&event)) handle(session, *goodbye, link);
  if (auto* live = std::get_if<LiveReceived>(&event)) handle(session, std::move(*live), link);
  if (const auto* where = std::get_if<WhereAsked>(&event)) handle(session, *where, link);
  if (const auto* asked = std::get_if<SurroundingsAsked>(&event)) ask(session, *asked, link);
  if (const auto* asked = std::get_if<MapAsked>(&event)) ask(session, *asked, link);
  if (const auto* asked = std::get_if<MapNextAsked>(&event)) ask(session, *asked, link);
  if (std::holds_alternative<TakenOver>(event)) take_over(session, link);
  if (std::holds_alternative<TriggerRequested>(event))  // an empty write: all that came before is durable then
    write(PutMerge{}, link, 0, [this, session] {
      const std::lock_guard lock(mutex_);
      news_.trigger(last_part(session), Trigger::request);
    });
}

void SessionHub::handle(SessionId session, KeyframeReceived event, const std::shared_ptr<RobotLink>& link,
                        std::size_t bytes) {
  const std::uint64_t sequence = event.keyframe.sequence;
  KeyframeRef keyframe;
  {
    const std::lock_guard lock(mutex_);
    carrier(session).backlog = event.backlog;
    keyframe = stored_as(session, sequence);
  }
  if (over_quota(session, 1, link, bytes)) return;
  event.keyframe.sequence = keyframe.sequence;
  write(PutKeyframe{keyframe.session, std::move(event.keyframe)}, link, bytes,
        [this, session, sequence, to = std::weak_ptr(link)] {
          KeyframeRef now;  // the session may have been split since
          {
            const std::lock_guard lock(mutex_);
            now = stored_as(session, sequence);
            auto& durable = sessions_.at(now.session).keyframes;
            durable = std::max(durable, now.sequence);
          }
          desk_.changed();
          news_.keyframes_durable(now.session, now.sequence);
          if (const auto robot = to.lock()) robot->keyframes_durable(sequence);
        });
}

/// Only over the connection that carries the session.
void SessionHub::handle(SessionId session, LiveReceived event, const std::shared_ptr<RobotLink>& link) {
  const std::lock_guard lock(mutex_);
  Session& known = carrier(session);
  if (known.link.lock() != link) return;
  known.backlog = event.backlog;
  known.live = {std::move(event.state), 0, known.live ? known.live->news + 1 : 1};
  known.live_came = Clock::now();
}

void SessionHub::handle(SessionId session, CloudReceived event, const std::shared_ptr<RobotLink>& link,
                        std::size_t bytes) {
  const std::uint64_t sent = event.sequence;
  if (over_quota(session, 0, link, bytes)) return;
  KeyframeRef cloud;
  {
    const std::lock_guard lock(mutex_);
    cloud = stored_as(session, sent);
    sessions_.at(cloud.session).cloud_bytes += event.encoded.size();
  }
  const auto durable = [this, session, sent, to = std::weak_ptr(link)] {
    KeyframeRef now;  // the session may have been split since
    {
      const std::lock_guard lock(mutex_);
      now = stored_as(session, sent);
      sessions_.at(now.session).clouds.insert(now.sequence);
    }
    news_.cloud_durable(now);
    if (const auto robot = to.lock()) robot->cloud_durable(sent);
  };
  const auto rejected = [this, session, sent, cloud, to = std::weak_ptr(link)](const Error& why) {
    {
      const std::lock_guard lock(mutex_);
      if (stored_as(session, sent) != cloud) return false;  // its keyframe was moved before it came there
    }
    note_refusal(session, {sent, why.message});
    if (const auto robot = to.lock()) robot->cloud_refused(sent, why.message);
    return true;
  };
  write(PutCloud{cloud, std::move(event.encoded)}, link, bytes, durable, rejected);
}

/// True: its robot has sent too much, and is told so. What it had acknowledged stays; it goes on when it may.
bool SessionHub::over_quota(SessionId session, int keyframes, const std::shared_ptr<RobotLink>& link,
                            std::size_t bytes) {
  std::string why;
  {
    const std::lock_guard lock(mutex_);
    why = quota_.stores(sessions_.at(session).record.key.robot, keyframes, bytes, Clock::now());
  }
  if (!why.empty()) link->settled(bytes, failure(ErrorCode::unavailable, why));
  return !why.empty();
}

/// Counted; the log gets the first of a session, and then ever fewer.
void SessionHub::note_refusal(SessionId session, const CloudRefused& cloud) {
  ++counts_.refused_clouds;
  {
    const std::lock_guard lock(mutex_);
    Session& known = carrier(session);
    if (std::has_single_bit(++known.refused_clouds))
      spdlog::warn("robot {}: the cloud of keyframe {} was refused: {} ({} so far)", name_of(known.record.key),
                   cloud.sequence, cloud.reason, known.refused_clouds);
  }
  tell_unavailable(session, {cloud.sequence});
}

void SessionHub::handle(SessionId session, const GoodbyeReceived& event, const std::shared_ptr<RobotLink>& link) {
  if (!event.complete) return;
  SessionId last = 0;
  {
    const std::lock_guard lock(mutex_);
    last = last_part(session);
  }
  write(CompleteSession{last}, link, 0, [this, session, last] {
    bool was_split = false;
    {
      const std::lock_guard lock(mutex_);
      sessions_.at(last).record.complete = true;
      was_split = last_part(session) != last;
    }
    news_.trigger(last, Trigger::goodbye);
    if (was_split) handle(session, GoodbyeReceived{true}, nullptr);
  });
}

/// Not under the lock: a full queue answers at once.
void SessionHub::write(Write write, const std::shared_ptr<RobotLink>& link, std::size_t bytes, Applied applied,
                       Rejected rejected) {
  ++unsettled_;
  store_.write(std::move(write), [this, bytes, applied = std::move(applied), rejected = std::move(rejected),
                                  to = std::weak_ptr(link)](const Result<void>& result) {
    if (result) applied();
    const bool dealt_with =
        !result && rejected && result.error().code == ErrorCode::invalid_argument && rejected(result.error());
    if (const auto robot = to.lock()) robot->settled(bytes, dealt_with ? Result<void>() : result);
    --unsettled_;  // last: who waits for it finds the worker and the robot told
  });
}

void SessionHub::received(SessionId session, std::size_t bytes) {
  const auto now = Clock::now();
  const std::lock_guard lock(mutex_);
  Session& known = carrier(session);
  known.bytes_received += bytes;
  known.rate.add(static_cast<double>(bytes), now);
  known.heard = now;
}

std::shared_ptr<RobotLink> SessionHub::link_of(SessionId session) const {
  const std::lock_guard lock(mutex_);
  return sessions_.contains(session) ? carrier(session).link.lock() : nullptr;
}

void SessionHub::request_submap(SessionId session, const std::vector<std::uint64_t>& sequences) {
  const auto robot = link_of(session);
  if (!robot) return news_.clouds_unavailable(session, sequences);  // it left between the question and this call
  std::vector<std::uint64_t> as_sent = sequences;
  {
    const std::lock_guard lock(mutex_);
    for (std::uint64_t& sequence : as_sent) sequence += sessions_.at(session).from - 1;
  }
  robot->request_submap(as_sent);
}

std::vector<SessionRow> SessionHub::sessions() const {
  const std::lock_guard lock(mutex_);
  std::vector<SessionRow> rows;
  const auto now = Clock::now();
  for (const auto& [id, s] : sessions_) {
    if (s.deleted) continue;
    auto& row = rows.emplace_back(SessionRow{id, s.record.key, s.record.family, s.record.sensor, !s.link.expired(),
                                             s.record.complete, s.keyframes, s.clouds.size() - s.let_go.size(),
                                             s.bytes_received});
    row.site = s.record.site;
    row.moves = s.moves;
    row.let_go = s.let_go.size();
    row.cloud_bytes = s.cloud_bytes;
    row.backlog = s.backlog;
    row.why_cut = cut_text(id, 0);
    row.bytes_per_s = s.rate.at(now);
    row.live = s.live;
    if (row.live) row.live->age_s = std::chrono::duration<double>(now - s.live_came).count();
    if (row.connected) row.link_age_s = std::chrono::duration<double>(now - s.heard).count();
  }
  return rows;
}

std::map<SessionId, SessionKey> SessionHub::keys() const {
  const std::lock_guard lock(mutex_);
  std::map<SessionId, SessionKey> keys;
  for (const auto& [id, session] : sessions_) keys[id] = session.record.key;
  return keys;
}

}  // namespace headframe
