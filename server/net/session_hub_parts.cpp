// What follows a jump of a session's odometry is a session of its own, a part, to everyone but the robot: it goes on
// over the same connection with its own name and numbers, and these are translated here.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>

#include "common/wire/limits.hpp"
#include "server/net/session_hub.hpp"

namespace headframe {
namespace {

constexpr char mark = '~';  // NAME~N

/// Which keyframe a part of this name begins with; 0: it is no part's name.
std::uint64_t first_of(const std::string& name, std::size_t at) {
  std::uint64_t first = 0;
  const char* end = name.data() + name.size();
  const auto read = std::from_chars(name.data() + at + 1, end, first);
  return read.ec == std::errc() && read.ptr == end ? first : 0;
}

/// The same numbers, counted from another one on.
template <class Numbers>
void count_from(std::uint64_t first, Numbers& numbers) {
  Numbers counted;
  for (auto it = numbers.lower_bound(first); it != numbers.end(); ++it) counted.insert(*it - first + 1);
  numbers.swap(counted);
}

}  // namespace

/// The whole, and its parts in order.
std::vector<SessionId> SessionHub::with_parts(SessionId session) const {
  const SessionId whole = sessions_.at(session).whole == 0 ? session : sessions_.at(session).whole;
  std::vector<SessionId> all{whole};
  const auto& parts = sessions_.at(whole).parts;
  all.insert(all.end(), parts.begin(), parts.end());
  return all;
}

SessionId SessionHub::before(SessionId part) const {
  const auto all = with_parts(part);
  return *std::prev(std::find(all.begin(), all.end(), part));
}

/// Of a keyframe that the robot numbers so.
KeyframeRef SessionHub::stored_as(SessionId session, std::uint64_t sent) const {
  const auto all = with_parts(session);
  const auto of =
      std::find_if(all.rbegin(), std::prev(all.rend()), [&](SessionId id) { return sessions_.at(id).from <= sent; });
  return {*of, sent - sessions_.at(*of).from + 1};
}

Durable SessionHub::durable_of(SessionId session) const {
  Durable durable;
  for (const SessionId id : with_parts(session)) {
    const Session& part = sessions_.at(id);
    durable.keyframes = part.from - 1 + part.keyframes;
    for (const std::uint64_t sequence : part.clouds) durable.clouds.push_back(part.from - 1 + sequence);
  }
  durable.pose_update = sessions_.at(with_parts(session).front()).record.pose_update;
  return durable;
}

void SessionHub::tell_came(SessionId session) {
  const bool answers = carrier(session).answers;
  for (const SessionId id : with_parts(session)) news_.robot_came(id, answers);
}

void SessionHub::tell_left(SessionId session) {
  for (const SessionId id : with_parts(session)) news_.robot_left(id);
}

void SessionHub::tell_unavailable(SessionId session, const std::vector<std::uint64_t>& sent) {
  std::map<SessionId, std::vector<std::uint64_t>> gone;
  {
    const std::lock_guard lock(mutex_);
    for (const std::uint64_t sequence : sent) {
      const KeyframeRef cloud = stored_as(session, sequence);
      gone[cloud.session].push_back(cloud.sequence);
    }
  }
  for (const auto& [id, sequences] : gone) news_.clouds_unavailable(id, sequences);
}

/// At its cut. Its connection carries the part from now on; what the robot was told of transforms means nothing there.
void SessionHub::split(SessionId id) {
  Session& ended = sessions_.at(id);
  const auto all = with_parts(id);
  const SessionKey& whole = sessions_.at(all.front()).record.key;
  const std::uint64_t from = ended.from + ended.cut.from - 1;
  const SessionKey key{whole.robot, whole.session + mark + std::to_string(from)};
  if (id != all.back() || ended.deleted) return;
  const bool may = all.size() <= most_parts && key.session.size() <= limits::name_bytes && !ids_.contains(key) &&
                   quota_.objection(key.robot, 0, true, Clock::now()).empty();
  const SessionId part = may ? new_part(id, key) : 0;
  spdlog::warn("robot {}: {}", name_of(whole), cut_text(id, ended.from - 1));
  if (!may) return;
  quota_.began_session(key.robot, Clock::now());
  if (told_.contains(id)) told_.insert(part);
  news_.session_added(part, {key.robot, ended.record.family, ended.record.site});
  const auto link = sessions_.at(part).link.lock();
  if (link) news_.robot_came(part, ended.answers);
  if (sessions_.at(part).asks_where) news_.asks_where(id, false);
  if (sessions_.at(part).asks_where) news_.asks_where(part, true);
  if (const auto transform = transform_of(part); link && transform) link->update_transform(transform);
  store_split(part);
}

SessionId SessionHub::new_part(SessionId id, const SessionKey& key) {
  Session& ended = sessions_.at(id);
  const std::uint64_t first = ended.cut.from;
  const SessionId part_id = sessions_.rbegin()->first + 1;
  Session& part = sessions_[part_id] = ended;
  ids_[key] = part_id;
  part.record.id = part_id;
  part.record.key = key;
  part.cut = {};
  part.whole = with_parts(id).front();
  part.from = ended.from + first - 1;
  part.parts.clear();
  part.keyframes = ended.keyframes < first ? 0 : ended.keyframes - first + 1;
  count_from(first, part.clouds);
  count_from(first, part.let_go);
  part.bytes_received = part.cloud_bytes = part.refused_clouds = 0;
  ended.keyframes = std::min(ended.keyframes, first - 1);
  ended.clouds.erase(ended.clouds.lower_bound(first), ended.clouds.end());
  ended.let_go.erase(ended.let_go.lower_bound(first), ended.let_go.end());
  ended.record.complete = true;
  ended.link.reset();
  ended.spares.clear();
  ended.live.reset();
  ended.asks_where = false;
  ended.backlog = 0;
  ended.rate = {};
  sessions_.at(part.whole).parts.push_back(part_id);
  return part_id;
}

/// Under the lock, so that what comes next for the part is stored after it.
void SessionHub::store_split(SessionId part) {
  Session& begun = sessions_.at(part);
  const SessionId ended = before(part);
  begun.split_waits = false;
  ++unsettled_;
  store_.write(SplitSession{ended, begun.from - sessions_.at(ended).from + 1, begun.record},
               [this, part, robot = begun.record.key.robot](const Result<void>& result) {
                 // A full queue answers at once, under the lock.
                 decoding_.submit(robot, [this, part, stored = result.has_value()] { split_stored(part, stored); });
               });
}

void SessionHub::split_stored(SessionId id, bool stored) {
  {
    const std::lock_guard lock(mutex_);
    Session& part = sessions_.at(id);
    part.split_waits = !stored;
    if (stored) {
      news_.trigger(before(id), Trigger::goodbye);
      news_.poses_durable(id);
      news_.keyframes_durable(id, part.keyframes);
      for (const std::uint64_t sequence : part.clouds)
        if (!part.let_go.contains(sequence)) news_.cloud_durable({id, sequence});
      news_.trigger(id, part.record.complete ? Trigger::goodbye : Trigger::link);
    }
  }
  desk_.changed();
  --unsettled_;
}

/// Of the sessions that were stored, by their names. What a robot named so itself does not follow its whole.
void SessionHub::find_parts() {
  std::map<SessionId, std::map<std::uint64_t, SessionId>> found;
  for (const auto& [id, session] : sessions_) {
    const SessionKey& key = session.record.key;
    const std::size_t at = key.session.rfind(mark);
    const auto whole = at == std::string::npos ? ids_.end() : ids_.find({key.robot, key.session.substr(0, at)});
    if (whole == ids_.end() || sessions_.at(whole->second).record.spool_id != session.record.spool_id) continue;
    if (const std::uint64_t first = first_of(key.session, at); first > 1) found[whole->second][first] = id;
  }
  for (const auto& [whole, parts] : found) {
    SessionId last = whole;
    for (const auto& [first, id] : parts) {
      const Session& ended = sessions_.at(last);
      if (!ended.deleted && first != ended.from + ended.keyframes) break;
      sessions_.at(id).whole = whole;
      sessions_.at(id).from = first;
      sessions_.at(whole).parts.push_back(id);
      if (told_.contains(last)) told_.insert(id);
      last = id;
    }
  }
}

/// Where the session's odometry jumped, and what became of what follows; empty: it did not. counted_before: what its
/// numbers begin after.
std::string SessionHub::cut_text(SessionId id, std::uint64_t counted_before) const {
  const Session& session = sessions_.at(id);
  const auto all = with_parts(id);
  const auto next = std::next(std::find(all.begin(), all.end(), id));
  const std::string from = "from keyframe ", why = session.cut.why.empty() ? "its odometry jumped" : session.cut.why;
  if (next != all.end()) {
    const Session& part = sessions_.at(*next);
    return from + std::to_string(part.from - session.from + 1 + counted_before) + " on it is session " +
           part.record.key.session + ", which is merged for itself: " + why;
  }
  if (session.cut.from == 0) return "";
  return from + std::to_string(session.cut.from + counted_before) + " on it is left out of merging: " + why +
         (session.cut.for_good ? "; begin a new session" : "");
}

std::string SessionHub::cut_text_for_robot(SessionId session) const {
  const SessionId last = last_part(session);
  std::string text = cut_text(last, sessions_.at(last).from - 1);
  if (text.empty() && sessions_.at(last).whole != 0) text = cut_text(before(last), sessions_.at(before(last)).from - 1);
  return text;
}

/// What a robot is told of a session: its own name is that of the part where it is now, and where it began is NAME~1.
/// receiver: that part; 0: of one without parts.
SessionKey SessionHub::key_for(SessionId receiver, SessionId session) const {
  const SessionKey& key = sessions_.at(session).record.key;
  const SessionId whole = receiver == 0 ? 0 : sessions_.at(receiver).whole;
  if (whole == 0) return key;
  if (session == receiver) return sessions_.at(whole).record.key;
  return session == whole ? SessionKey{key.robot, key.session + mark + "1"} : key;
}

}  // namespace headframe
