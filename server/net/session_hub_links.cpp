// Which connections a session has: the one that carries it, and its spares.
#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/wire/capabilities.hpp"
#include "server/net/session_hub.hpp"

namespace headframe {
namespace {

bool same_family(const SessionRecord& record, const FamilySpec& family) {
  return record.family == family.id && record.q_size == family.q_size && record.w_size == family.w_size;
}

/// What speaks against a robot that wants to write to this session; empty: nothing.
std::string objection(const SessionRecord& record, const Hello& hello) {
  const std::string session = "session " + SessionHub::name_of(record.key);
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

/// The hello's session, made when it is new; of one with parts the last. Under the lock.
SessionHub::Session& SessionHub::session_of(const Hello& hello) {
  if (const auto known = ids_.find(hello.session); known != ids_.end()) return carrier(known->second);
  quota_.began_session(hello.session.robot, Clock::now());
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
  if (const auto site = robot_sites_.find(hello.session.robot); site != robot_sites_.end())
    session.record.site = site->second;
  return session;
}

/// The connection that this one replaces does not count. The robot's own bounds come first: who has reached them learns
/// so, and not that others have. Under the lock.
std::string SessionHub::want_of_room(const Hello& hello) const {
  int all = 0, own = 0;
  const auto known = ids_.find(hello.session);
  const SessionId replaced = known == ids_.end() ? 0 : last_part(known->second);
  for (const auto& [id, session] : sessions_) {
    if (session.link.expired() || id == replaced) continue;
    ++all;
    own += session.record.key.robot == hello.session.robot ? 1 : 0;
  }
  if (auto why = quota_.objection(hello.session.robot, own, known == ids_.end(), Clock::now()); !why.empty())
    return why;
  if (all < limits_.robots) return "";
  return "the server serves " + std::to_string(limits_.robots) +
         " robots already; raise limits.robots or try again later";
}

Result<SessionHub::Admitted> SessionHub::admit(const Hello& hello, const std::shared_ptr<RobotLink>& link) {
  Admitted admitted;
  SessionRecord record;
  std::shared_ptr<RobotLink> replaced;
  std::vector<std::weak_ptr<RobotLink>> spares;  // of another run
  {
    const std::lock_guard lock(mutex_);
    if (const auto beside = stand_by(hello, link)) return *beside;
    if (const std::string why = want_of_room(hello); !why.empty()) return failure(ErrorCode::unavailable, why);
    if (const auto known = ids_.find(hello.session); known != ids_.end() && sessions_.at(known->second).whole != 0)
      return failure(ErrorCode::refused, "session " + name_of(hello.session) + " was made by the server, of " +
                                             name_of(sessions_.at(sessions_.at(known->second).whole).record.key) +
                                             "; choose another session name");
    Session& session = session_of(hello);
    if (session.deleted)
      return failure(ErrorCode::refused, "session " + name_of(hello.session) +
                                             " was deleted by the operator; begin a new session, with an empty spool");
    if (const std::string why = objection(session.record, hello); !why.empty()) return failure(ErrorCode::refused, why);
    if (!same_run(session.record, hello)) spares.swap(session.spares);
    if (!hello.spool_runs.empty()) session.record.spool_run = hello.spool_runs.back();
    record = session.record;
    replaced = session.link.lock();
    session.link = link;
    session.heard = Clock::now();
    session.answers = hello.clouds != CloudPolicy::never;
    const auto lists = [&](std::string_view name) {
      return std::find(hello.capabilities.begin(), hello.capabilities.end(), name) != hello.capabilities.end();
    };
    session.wants_provisional = lists(provisional_capability);
    session.takes_pages = lists(transform_pages_capability);
    session.takes_supports = lists(transform_support_capability);
    session.asks_where = false;
    desk_.left(with_parts(session.record.id).front());
    admitted = {with_parts(record.id).front(), durable_of(record.id), transform_of(record.id)};
    news_.session_added(record.id, {record.key.robot, record.family, record.site});
    if (replaced) tell_left(record.id);  // what was asked of the old connection has to be asked again
    tell_came(record.id);
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
  if (!hello.spare || known == ids_.end() || carrier(known->second).link.expired()) return std::nullopt;
  Session& session = carrier(known->second);
  if (const std::string why = objection(session.record, hello); !why.empty()) return failure(ErrorCode::refused, why);
  if (!same_run(session.record, hello))
    return failure(ErrorCode::unavailable, "a spare of another run of its spool: begin with a hello that is none");
  if (limits_.spares == 0)
    return failure(ErrorCode::unavailable, "this server takes no spares (limits.spares = 0), as its welcome says");
  auto& spares = session.spares;
  std::erase_if(spares, [](const auto& spare) { return spare.expired(); });
  if (spares.size() >= static_cast<std::size_t>(limits_.spares)) {
    if (const auto oldest = spares.front().lock())
      oldest->close(v1::ERROR_KIND_OVERLOADED,
                    "more spares than the " + std::to_string(limits_.spares) + " that limits.spares allows", false);
    spares.erase(spares.begin());
  }
  spares.push_back(link);
  Durable durable = durable_of(known->second);
  durable.clouds.clear();
  return Admitted{known->second, std::move(durable), nullptr};
}

/// From a spare; one that was closed meanwhile is not in the list.
void SessionHub::take_over(SessionId id, const std::shared_ptr<RobotLink>& link) {
  const std::lock_guard lock(mutex_);
  Session& session = carrier(id);
  const auto before = session.link.lock();
  const auto same = [&](const auto& spare) { return spare.lock() == link; };
  if (before != link && std::erase_if(session.spares, same) == 0) return;
  if (before && before != link) {
    before->stand_by();
    session.spares.push_back(before);
  }
  session.link = link;
  tell_left(id);  // what was asked of the other has to be asked again
  tell_came(id);
  if (session.asks_where) news_.asks_where(session.record.id, true);
  if (const auto transform = transform_of(session.record.id)) link->update_transform(transform);
}

void SessionHub::left(SessionId session, const RobotLink* link) {
  const std::lock_guard lock(mutex_);
  Session& known = carrier(session);
  std::erase_if(known.spares, [&](const auto& spare) { return spare.expired() || spare.lock().get() == link; });
  if (known.link.lock().get() != link) return;  // replaced before
  known.link.reset();
  known.asks_where = false;
  desk_.left(session);
  tell_left(session);
  spdlog::info("robot {} left", name_of(known.record.key));
}

void SessionHub::forget(SessionId id) {
  std::vector<std::shared_ptr<RobotLink>> ended;
  {
    const std::lock_guard lock(mutex_);
    Session& session = sessions_.at(id);
    session.deleted = true;
    session.keyframes = 0;
    session.clouds.clear();
    session.let_go.clear();
    ended.push_back(session.link.lock());
    for (const auto& spare : session.spares) ended.push_back(spare.lock());
  }
  for (const auto& link : ended)
    if (link) link->close(v1::ERROR_KIND_REFUSED, "the session was deleted by the operator", true);
}

void SessionHub::let_go(SessionId id, const std::vector<std::uint64_t>& sequences) {
  const std::lock_guard lock(mutex_);
  Session& session = sessions_.at(id);
  if (session.deleted) return;
  session.clouds.insert(sequences.begin(), sequences.end());
  session.let_go.insert(sequences.begin(), sequences.end());
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

}  // namespace headframe
