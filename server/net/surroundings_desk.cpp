#include "server/net/surroundings_desk.hpp"

#include <algorithm>

#include "server/net/surroundings_pages.hpp"

namespace headframe {
namespace {

using Kind = SurroundingsKind;
const std::string alone = "this session is merged with no other yet: there is nothing that others know";

// What a robot holds that was told why there is nothing; epochs of maps are drawn, and never so small.
constexpr HeldVersion told_alone{1, 1}, told_busy{1, 2};

template <class Message>
SurroundingsDesk::Payload payload_of(void (v1::ServerMessage::*set)(Message*), Message message) {
  v1::ServerMessage out;
  (out.*set)(new Message(std::move(message)));  // which is the message's from here on
  return std::make_shared<const std::string>(out.SerializeAsString());
}

SurroundingsDesk::Payload no_page(Kind kind, const HeldVersion& held, const std::string& why) {
  v1::ServerMessage out;
  auto& page = kind == Kind::trajectories ? *out.mutable_trajectories()->mutable_page()
                                          : *out.mutable_coverage()->mutable_page();
  page = nothing_to_tell(held, why);
  return std::make_shared<const std::string>(out.SerializeAsString());
}

double time_of_day_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace

void SurroundingsDesk::stop() {
  maps_.stop();
  {
    const std::lock_guard lock(mutex_);
    asking_.clear();
    stopped_ = true;
  }
  pool_.reset();
}

/// Who asks has got what was on its way; the next page is larger if that was quick, and smaller if it was slow.
SurroundingsDesk::Asking& SurroundingsDesk::asks(SessionId session) {
  Asking& asking = asking_[session];
  if (asking.waits_until != Clock::time_point{}) {
    const auto took = now_() - asking.answered;
    if (took < quick) asking.page_bytes = std::min(asking.page_bytes * 2, most_page_bytes);
    if (took > slow) asking.page_bytes = std::max(asking.page_bytes / 2, least_page_bytes);
  }
  asking.waits_until = {};
  return asking;
}

void SurroundingsDesk::ask(SessionId session, const SurroundingsAsked& question) {
  {
    const std::lock_guard lock(mutex_);
    Asking& asking = asks(session);
    asking.questions.erase(question.kind);
    if (question.asks) asking.questions[question.kind].held = question.held;
  }
  go_on(session);
}

void SurroundingsDesk::ask(SessionId session, const MapAsked& question) {
  {
    const std::lock_guard lock(mutex_);
    asks(session).map = Map{.question = question, .wanted = 0, .head = {}, .encoded = {}};
  }
  go_on(session);
}

void SurroundingsDesk::ask(SessionId session, const MapNextAsked& question) {
  {
    const std::lock_guard lock(mutex_);
    Asking& asking = asks(session);
    if (asking.map && asking.map->question.id == question.id && question.offset < asking.map->encoded.size())
      asking.map->wanted = question.offset;
  }
  go_on(session);
}

void SurroundingsDesk::left(SessionId session) {
  const std::lock_guard lock(mutex_);
  asking_.erase(session);
}

void SurroundingsDesk::look(SessionId session, std::uint64_t bytes_per_s) {
  {
    const std::lock_guard lock(mutex_);
    const auto asking = asking_.find(session);
    if (asking == asking_.end()) return;
    asking->second.bytes_per_s = bytes_per_s;
  }
  go_on(session);
}

bool SurroundingsDesk::due(const Question& question, std::uint64_t changes, Clock::time_point now) {
  return !question.looked || (question.changes != changes && now - question.looked_at >= look_every);
}

/// What is to be answered now: another kind than the last time if it can be.
std::optional<Kind> SurroundingsDesk::next(const Asking& asking, Clock::time_point now) const {
  if (stopped_ || asking.working || now < asking.waits_until || now < asking.paced_until) return std::nullopt;
  constexpr int kinds = 3;
  for (int step = 1; step <= kinds; ++step) {
    const auto kind = static_cast<Kind>((static_cast<int>(asking.last) + step) % kinds);
    const auto question = asking.questions.find(kind);
    if (kind == Kind::map && asking.map && asking.map->wanted) return kind;
    if (question != asking.questions.end() && due(question->second, changes_, now)) return kind;
  }
  return std::nullopt;
}

void SurroundingsDesk::note_sent(Asking& asking, Kind kind, std::size_t bytes) const {
  const auto now = now_();
  asking.last = kind;
  asking.answered = now;
  asking.waits_until = now + unasked;
  if (asking.bytes_per_s > 0)
    asking.paced_until = now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(
                                   static_cast<double>(bytes) / static_cast<double>(asking.bytes_per_s)));
}

SurroundingsDesk::Payload SurroundingsDesk::part(Map& map, std::size_t page_bytes) {
  v1::MapPart part;
  if (*map.wanted == 0) part = map.head;
  part.set_id(map.question.id);
  part.set_offset(*map.wanted);
  part.set_data(map.encoded.substr(*map.wanted, page_bytes));
  map.wanted.reset();
  return payload_of(&v1::ServerMessage::set_allocated_map_part, std::move(part));
}

/// A part of a map that is made needs no work: it is told at once.
void SurroundingsDesk::go_on(SessionId session) {
  Payload told;
  {
    const std::lock_guard lock(mutex_);
    const auto entry = asking_.find(session);
    if (entry == asking_.end()) return;
    Asking& asking = entry->second;
    const auto kind = next(asking, now_());
    if (!kind) return;
    if (*kind == Kind::map && asking.map->made) {
      told = part(*asking.map, asking.page_bytes);
      note_sent(asking, *kind, told->size());
    } else {
      asking.working = true;
      pool_->submit(std::to_string(session), [this, session, kind = *kind] { work(session, kind); });
    }
  }
  if (told) tell_(session, Kind::map, std::move(told));
}

void SurroundingsDesk::work(SessionId session, Kind kind) {
  std::optional<HeldVersion> held;
  std::optional<MapAsked> map;
  std::size_t page_bytes = least_page_bytes;
  {
    const std::lock_guard lock(mutex_);
    const auto entry = asking_.find(session);
    if (entry == asking_.end()) return;  // it left
    const auto question = entry->second.questions.find(kind);
    if (kind == Kind::map && entry->second.map) map = entry->second.map->question;
    if (question != entry->second.questions.end()) {
      question->second.looked = true;
      question->second.changes = changes_;
      question->second.looked_at = now_();
      held = question->second.held;
      page_bytes = entry->second.page_bytes;
    }
  }
  if (map) make_map(session, *map);
  if (held) answer(session, kind, *held, page_bytes);
  {
    const std::lock_guard lock(mutex_);
    if (const auto entry = asking_.find(session); entry != asking_.end()) entry->second.working = false;
  }
  go_on(session);
}

void SurroundingsDesk::answer(SessionId session, Kind kind, const HeldVersion& held, std::size_t page_bytes) {
  const Payload told = page(session, kind, held, page_bytes);
  if (!told) return;  // the question stands
  {
    const std::lock_guard lock(mutex_);
    const auto entry = asking_.find(session);
    if (entry == asking_.end()) return;
    const auto question = entry->second.questions.find(kind);
    if (question == entry->second.questions.end() || !(question->second.held == held)) return;  // it asked another
    entry->second.questions.erase(question);
    note_sent(entry->second, kind, told->size());
  }
  tell_(session, kind, told);
}

/// Null: nothing is newer than what the robot holds.
SurroundingsDesk::Payload SurroundingsDesk::page(SessionId session, Kind kind, const HeldVersion& held,
                                                 std::size_t page_bytes) {
  const SessionSurroundings around = around_(session);
  if (around.component.placements.size() < 2) return held == told_alone ? nullptr : no_page(kind, told_alone, alone);
  const auto known = maps_.refreshed(around, now_());
  if (!known) return held == told_busy ? nullptr : no_page(kind, told_busy, known.error().message);
  const std::uint64_t from = held.epoch == known->epoch ? held.version : 0;
  const auto piece = kind == Kind::trajectories ? known->map->paths_after(from, around.receiver, page_bytes)
                                                : known->map->coverage_after(from, page_bytes);
  if (!piece) return nullptr;
  if (kind == Kind::trajectories)
    return payload_of(&v1::ServerMessage::set_allocated_trajectories,
                      trajectories_page(around, held, *known, *piece, time_of_day_s()));
  return payload_of(&v1::ServerMessage::set_allocated_coverage,
                    coverage_page(around, held, *known, *piece, time_of_day_s()));
}

void SurroundingsDesk::make_map(SessionId session, const MapAsked& question) {
  const SessionSurroundings around = around_(session);
  v1::MapPart head;
  std::string encoded;
  if (around.component.placements.size() < 2) {
    head.set_refused(alone);
  } else if (auto made = maps_.map_of(around, question.region, question.resolution_m, question.since, now_())) {
    head = map_head(question.id, around.revision, *made);
    encoded = std::move(made->encoded);
  } else {
    head.set_refused(made.error().message);
  }
  const std::lock_guard lock(mutex_);
  const auto entry = asking_.find(session);
  if (entry == asking_.end() || !entry->second.map || entry->second.map->question.id != question.id) return;
  entry->second.map->head = std::move(head);
  entry->second.map->encoded = std::move(encoded);
  entry->second.map->made = true;
}

}  // namespace headframe
