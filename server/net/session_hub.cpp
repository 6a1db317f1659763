#include "server/net/session_hub.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <bit>

namespace headframe {
namespace {

constexpr std::size_t keyframe_bytes = 1024;  // of memory until it is on disk, about

std::string name_of(const SessionKey& key) { return key.robot + "/" + key.session; }

bool same_family(const SessionRecord& record, const FamilySpec& family) {
  return record.family == family.id && record.q_size == family.q_size && record.w_size == family.w_size;
}

/// What speaks against a robot that wants to write to this session; empty: nothing.
std::string objection(const SessionRecord& record, const Hello& hello) {
  const std::string session = "session " + name_of(record.key);
  if (record.spool_id != hello.spool_id)
    return session + " is fed from another spool; use that spool, or another session name";
  const auto& runs = hello.spool_runs;
  if (record.spool_run != 0 && !runs.empty() && std::find(runs.begin(), runs.end(), record.spool_run) == runs.end())
    return session + " has gone on with another copy of this spool: one of the two disks is a clone; begin a new " +
           "session here, with an empty spool";
  if (!same_family(record, hello.family))
    return session + " was begun with descriptor family " + record.family.name + " version " +
           std::to_string(record.family.version) + " of " + std::to_string(record.q_size) + " + " +
           std::to_string(record.w_size) + " numbers; begin a new session";
  return "";
}

bool same_run(const SessionRecord& record, const Hello& hello) {
  return !hello.spool_runs.empty() && record.spool_run == hello.spool_runs.back();
}

}  // namespace

Result<void> SessionHub::restore() {
  auto sessions = store_.sessions();
  if (!sessions) return tl::unexpected(sessions.error());
  auto merge = store_.merge();
  if (!merge) return tl::unexpected(merge.error());
  const std::lock_guard lock(mutex_);
  for (const SessionRecord& record : *sessions) {
    auto clouds = store_.cloud_sequences(record.id);
    if (!clouds) return tl::unexpected(clouds.error());
    auto keyframes = store_.last_keyframe(record.id);
    if (!keyframes) return tl::unexpected(keyframes.error());
    Session& session = sessions_[record.id];
    session.record = record;
    session.keyframes = *keyframes;
    session.clouds = {clouds->begin(), clouds->end()};
    ids_[record.key] = record.id;
  }
  atlas_ = std::move(merge->atlas);
  for (const Component& component : atlas_.components)
    for (const Placement& placement : component.placements)
      if (component.placements.size() > 1) told_.insert(placement.session);
  for (const Alignment& alignment : merge->alignments)
    if (alignment.state == AlignmentState::retracted) told_.insert({alignment.a, alignment.b});
  return {};
}

/// The hello's session, made when it is new. Under the lock.
SessionHub::Session& SessionHub::session_of(const Hello& hello) {
  if (const auto known = ids_.find(hello.session); known != ids_.end()) return sessions_.at(known->second);
  const SessionId id = sessions_.empty() ? 1 : sessions_.rbegin()->first + 1;
  ids_[hello.session] = id;
  Session& session = sessions_[id];
  session.record = {id,
                    hello.session,
                    hello.sensor,
                    hello.family.id,
                    static_cast<std::uint32_t>(hello.family.q_size),
                    static_cast<std::uint32_t>(hello.family.w_size),
                    hello.spool_id};
  return session;
}

/// Room for one more robot; the one it replaces does not count. Under the lock.
bool SessionHub::has_room(const Hello& hello) const {
  const auto others = std::count_if(sessions_.begin(), sessions_.end(), [&](const auto& session) {
    return !session.second.link.expired() && session.second.record.key != hello.session;
  });
  return others < limits_.robots;
}

Result<SessionHub::Admitted> SessionHub::admit(const Hello& hello, const std::shared_ptr<RobotLink>& link) {
  Admitted admitted;
  SessionRecord record;
  std::shared_ptr<RobotLink> replaced;
  std::vector<std::weak_ptr<RobotLink>> spares;  // of another run
  {
    const std::lock_guard lock(mutex_);
    if (const auto beside = stand_by(hello, link)) return *beside;
    if (!has_room(hello))
      return failure(ErrorCode::unavailable, "the server serves " + std::to_string(limits_.robots) +
                                                 " robots already; raise limits.robots or try again later");
    Session& session = session_of(hello);
    if (const std::string why = objection(session.record, hello); !why.empty()) return failure(ErrorCode::refused, why);
    if (!same_run(session.record, hello)) spares.swap(session.spares);
    if (!hello.spool_runs.empty()) session.record.spool_run = hello.spool_runs.back();
    record = session.record;
    replaced = session.link.lock();
    session.link = link;
    session.heard = Clock::now();
    session.answers = hello.clouds != CloudPolicy::never;
    admitted = {
        record.id, {session.keyframes, {session.clouds.begin(), session.clouds.end()}}, transform_of(record.id)};
    news_.session_added(record.id, record.family);
    if (replaced) news_.robot_left(record.id);  // what was asked of the old connection has to be asked again
    news_.robot_came(record.id, session.answers);
    news_.trigger(record.id, Trigger::link);
  }
  if (replaced) ++counts_.replaced;
  if (replaced) replaced->close(v1::ERROR_KIND_REFUSED, "replaced by a newer connection of the same spool", false);
  for (const auto& spare : spares)
    if (const auto old = spare.lock()) old->close(v1::ERROR_KIND_REFUSED, "its robot was started anew", false);
  write(PutSession{record}, link, 0, [] {});
  spdlog::info("robot {} connected ({}): {} keyframes and {} clouds are here", name_of(record.key), hello.software,
               admitted.durable.keyframes, admitted.durable.clouds.size());
  return admitted;
}

/// nullopt: there is nobody to stand beside. Under the lock.
std::optional<Result<SessionHub::Admitted>> SessionHub::stand_by(const Hello& hello,
                                                                 const std::shared_ptr<RobotLink>& link) {
  const auto known = ids_.find(hello.session);
  if (!hello.spare || known == ids_.end() || sessions_.at(known->second).link.expired()) return std::nullopt;
  Session& session = sessions_.at(known->second);
  if (const std::string why = objection(session.record, hello); !why.empty()) return failure(ErrorCode::refused, why);
  if (!same_run(session.record, hello)) return failure(ErrorCode::unavailable, "a spare of another run of its spool");
  if (limits_.spares == 0) return failure(ErrorCode::unavailable, "limits.spares is 0");
  auto& spares = session.spares;
  std::erase_if(spares, [](const auto& spare) { return spare.expired(); });
  if (spares.size() >= static_cast<std::size_t>(limits_.spares)) {
    if (const auto oldest = spares.front().lock())
      oldest->close(v1::ERROR_KIND_OVERLOADED, "more spares than limits.spares", false);
    spares.erase(spares.begin());
  }
  spares.push_back(link);
  return Admitted{known->second, {session.keyframes, {}}, nullptr};
}

/// From a spare; one that was closed meanwhile is not in the list.
void SessionHub::take_over(SessionId id, const std::shared_ptr<RobotLink>& link) {
  const std::lock_guard lock(mutex_);
  Session& session = sessions_.at(id);
  const auto before = session.link.lock();
  const auto same = [&](const auto& spare) { return spare.lock() == link; };
  if (before != link && std::erase_if(session.spares, same) == 0) return;
  if (before && before != link) {
    before->stand_by();
    session.spares.push_back(before);
  }
  session.link = link;
  news_.robot_left(id);  // what was asked of the other has to be asked again
  news_.robot_came(id, session.answers);
  if (const auto transform = transform_of(id)) link->update_transform(transform);
}

std::uint64_t SessionHub::durable_keyframes(SessionId session) const {
  const std::lock_guard lock(mutex_);
  return sessions_.at(session).keyframes;
}

std::size_t SessionHub::stored_bytes(const RobotEvent& event) {
  if (std::holds_alternative<KeyframeReceived>(event)) return keyframe_bytes;
  if (const auto* cloud = std::get_if<CloudReceived>(&event)) return cloud->encoded.size() + keyframe_bytes;
  return 0;
}

void SessionHub::take(SessionId session, RobotEvent event, const std::shared_ptr<RobotLink>& link) {
  const std::size_t bytes = stored_bytes(event);
  if (auto* keyframe = std::get_if<KeyframeReceived>(&event)) handle(session, std::move(*keyframe), link, bytes);
  if (auto* cloud = std::get_if<CloudReceived>(&event)) handle(session, std::move(*cloud), link, bytes);
  if (const auto* refused = std::get_if<CloudRefused>(&event)) note_refusal(session, *refused);
  if (const auto* gone = std::get_if<CloudsUnavailable>(&event)) news_.clouds_unavailable(session, gone->sequences);
  if (const auto* goodbye = std::get_if<GoodbyeReceived>(&event)) handle(session, *goodbye, link);
  if (std::holds_alternative<TakenOver>(event)) take_over(session, link);
  if (std::holds_alternative<TriggerRequested>(event))  // an empty write: all that came before is durable then
    write(PutMerge{}, link, 0, [this, session] { news_.trigger(session, Trigger::request); });
}

void SessionHub::handle(SessionId session, KeyframeReceived event, const std::shared_ptr<RobotLink>& link,
                        std::size_t bytes) {
  const std::uint64_t sequence = event.keyframe.sequence;
  {
    const std::lock_guard lock(mutex_);
    sessions_.at(session).backlog = event.backlog;
  }
  write(PutKeyframe{session, std::move(event.keyframe)}, link, bytes,
        [this, session, sequence, to = std::weak_ptr(link)] {
          {
            const std::lock_guard lock(mutex_);
            auto& durable = sessions_.at(session).keyframes;
            durable = std::max(durable, sequence);
          }
          news_.keyframes_durable(session, sequence);
          if (const auto robot = to.lock()) robot->keyframes_durable(sequence);
        });
}

void SessionHub::handle(SessionId session, CloudReceived event, const std::shared_ptr<RobotLink>& link,
                        std::size_t bytes) {
  const KeyframeRef cloud{session, event.sequence};
  {
    const std::lock_guard lock(mutex_);
    sessions_.at(session).cloud_bytes += event.encoded.size();
  }
  const auto durable = [this, cloud, to = std::weak_ptr(link)] {
    {
      const std::lock_guard lock(mutex_);
      sessions_.at(cloud.session).clouds.insert(cloud.sequence);
    }
    news_.cloud_durable(cloud);
    if (const auto robot = to.lock()) robot->cloud_durable(cloud.sequence);
  };
  const auto rejected = [this, cloud, to = std::weak_ptr(link)](const Error& why) {
    note_refusal(cloud.session, {cloud.sequence, why.message});
    if (const auto robot = to.lock()) robot->cloud_refused(cloud.sequence, why.message);
  };
  write(PutCloud{cloud, std::move(event.encoded)}, link, bytes, durable, rejected);
}

/// Counted; the log gets the first of a session, and then ever fewer.
void SessionHub::note_refusal(SessionId session, const CloudRefused& cloud) {
  ++counts_.refused_clouds;
  {
    const std::lock_guard lock(mutex_);
    Session& known = sessions_.at(session);
    if (std::has_single_bit(++known.refused_clouds))
      spdlog::warn("robot {}: the cloud of keyframe {} was refused: {} ({} so far)", name_of(known.record.key),
                   cloud.sequence, cloud.reason, known.refused_clouds);
  }
  news_.clouds_unavailable(session, {cloud.sequence});
}

void SessionHub::handle(SessionId session, const GoodbyeReceived& event, const std::shared_ptr<RobotLink>& link) {
  if (!event.complete) return;
  write(CompleteSession{session}, link, 0, [this, session] {
    {
      const std::lock_guard lock(mutex_);
      sessions_.at(session).record.complete = true;
    }
    news_.trigger(session, Trigger::goodbye);
  });
}

/// Not under the lock: a full queue answers at once.
void SessionHub::write(Write write, const std::shared_ptr<RobotLink>& link, std::size_t bytes, Applied applied,
                       Rejected rejected) {
  ++unsettled_;
  store_.write(std::move(write), [this, bytes, applied = std::move(applied), rejected = std::move(rejected),
                                  to = std::weak_ptr(link)](const Result<void>& result) {
    const bool dealt_with = !result && rejected && result.error().code == ErrorCode::invalid_argument;
    if (result) applied();
    if (dealt_with) rejected(result.error());
    --unsettled_;
    if (const auto robot = to.lock()) robot->settled(bytes, dealt_with ? Result<void>() : result);
  });
}

void SessionHub::received(SessionId session, std::size_t bytes) {
  const auto now = Clock::now();
  const std::lock_guard lock(mutex_);
  Session& known = sessions_.at(session);
  known.bytes_received += bytes;
  known.rate.add(static_cast<double>(bytes), now);
  known.heard = now;
}

void SessionHub::left(SessionId session, const RobotLink* link) {
  const std::lock_guard lock(mutex_);
  Session& known = sessions_.at(session);
  std::erase_if(known.spares, [&](const auto& spare) { return spare.expired() || spare.lock().get() == link; });
  if (known.link.lock().get() != link) return;  // replaced before
  known.link.reset();
  news_.robot_left(session);
  spdlog::info("robot {} left", name_of(known.record.key));
}

void SessionHub::end_robot(const std::string& robot, const std::string& why) {
  std::vector<std::shared_ptr<RobotLink>> ended;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, session] : sessions_)
      if (session.record.key.robot == robot) {
        ended.push_back(session.link.lock());
        for (const auto& spare : session.spares) ended.push_back(spare.lock());
      }
  }
  const std::string reason = "robot " + robot + ": " + why;
  for (const auto& link : ended)
    if (link) link->close(v1::ERROR_KIND_REFUSED, reason, true);
}

std::shared_ptr<RobotLink> SessionHub::link_of(SessionId session) const {
  const std::lock_guard lock(mutex_);
  const auto it = sessions_.find(session);
  return it == sessions_.end() ? nullptr : it->second.link.lock();
}

void SessionHub::request_submap(SessionId session, const std::vector<std::uint64_t>& sequences) {
  if (const auto robot = link_of(session))
    robot->request_submap(sequences);
  else
    news_.clouds_unavailable(session, sequences);  // it left between the question and this call
}

std::vector<SessionRow> SessionHub::sessions() const {
  const std::lock_guard lock(mutex_);
  std::vector<SessionRow> rows;
  const auto now = Clock::now();
  for (const auto& [id, s] : sessions_) {
    auto& row = rows.emplace_back(SessionRow{id, s.record.key, s.record.family, s.record.sensor, !s.link.expired(),
                                             s.record.complete, s.keyframes, s.clouds.size(), s.bytes_received});
    row.cloud_bytes = s.cloud_bytes;
    row.backlog = s.backlog;
    row.bytes_per_s = s.rate.at(now);
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
