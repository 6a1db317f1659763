#include "server/store/postgres_presence.hpp"

#include <algorithm>
#include <utility>

namespace headframe {
namespace {

constexpr auto beat_every = std::chrono::seconds(1);

// By the database's clock alone, so that those of the servers need not agree. A server is active when the writer's mark
// is its own, whatever it believes.
constexpr const char* note_self =
    "INSERT INTO servers (id, name, robots, http, fingerprint, token_digest, active, since_s, heard_s)"
    " VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, extract(epoch FROM clock_timestamp())::float8 - ?8,"
    " extract(epoch FROM clock_timestamp())::float8) ON CONFLICT (id) DO UPDATE SET heard_s = excluded.heard_s,"
    " active = excluded.active, since_s = excluded.since_s";
constexpr const char* note_relayed = "UPDATE servers SET relayed = ?2, loopback = ?3 WHERE id = ?1";
constexpr const char* note_searched =
    "UPDATE servers SET searched = ?2, searches_a = ?3, searches_b = ?4 WHERE id = ?1";
constexpr const char* forget_those_that_went =
    "DELETE FROM servers WHERE heard_s < extract(epoch FROM clock_timestamp())::float8 - ?";
// Columns `relayed`, `loopback` and those of searches are not there while the active server is an older one.
constexpr const char* see_all =
    "SELECT name, robots, http, id = owner, id = ?1, since_s, extract(epoch FROM clock_timestamp())::float8 - heard_s,"
    " active, (to_jsonb(servers) ->> 'relayed')::bigint, coalesce(to_jsonb(servers) ->> 'loopback', ''),"
    " (to_jsonb(servers) ->> 'searched')::bigint, coalesce((to_jsonb(servers) ->> 'searches_a')::bigint, 0),"
    " coalesce((to_jsonb(servers) ->> 'searches_b')::bigint, 0) FROM servers, writer ORDER BY id = owner DESC, name, "
    "id";

}  // namespace

PostgresPresence::PostgresPresence(const std::string& url, const std::string& database,
                                   std::function<void(const Error&)> taken_over, std::function<StandbyWork()> work)
    : database_(url, database), taken_over_(std::move(taken_over)), work_(std::move(work)) {}

PostgresPresence::~PostgresPresence() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
  if (!card_ || !database_.is_connected()) return;
  if (database_.run("DELETE FROM servers WHERE id = ?", card_->id)) (void)database_.settle();
}

void PostgresPresence::start(const ServerCard& card) {
  const std::lock_guard lock(mutex_);
  if (!card_) since_ = Clock::now();
  card_ = card;
  if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
}

void PostgresPresence::become_active() {
  {
    const std::lock_guard lock(mutex_);
    active_ = true;
    since_ = Clock::now();
  }
  wake_.notify_all();
}

std::vector<ServerRecord> PostgresPresence::servers() const {
  const std::lock_guard lock(mutex_);
  std::vector<ServerRecord> now = seen_;
  const double since_look_s = std::chrono::duration<double>(Clock::now() - seen_at_).count();
  for (ServerRecord& server : now) server.heard_ago_s += server.is_self ? 0 : since_look_s;
  std::erase_if(now, [](const ServerRecord& s) { return !s.is_self && s.heard_ago_s > gone_after_s; });
  if (now.empty() && card_) now.push_back({card_->name, card_->robots, card_->http, active_, true, 0, 0});
  return now;
}

void PostgresPresence::run() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const bool was_active = active_;
    lock.unlock();
    beat();
    lock.lock();
    wake_.wait_for(lock, beat_every, [&] { return stopping_ || active_ != was_active; });
  }
}

void PostgresPresence::beat() {
  std::optional<ServerCard> card;
  bool active = false;
  double for_s = 0;
  {
    const std::lock_guard lock(mutex_);
    card = card_;
    active = active_;
    for_s = std::chrono::duration<double>(Clock::now() - since_).count();
  }
  Result<void> done;
  if (!database_.is_connected()) {
    done = database_.connect();
    if (done) done = database_.execute("SET synchronous_commit = off");  // nobody's disk is waited for
  }
  if (done) done = note(*card, active, for_s);
  if (done) (void)look(*card, active);
  counts_relayed_ = counts_relayed_ && done;
  counts_searched_ = counts_searched_ && done;
}

Result<void> PostgresPresence::note(const ServerCard& card, bool active, double for_s) {
  auto done = database_.run(note_self, card.id, std::string_view(card.name), std::string_view(card.robots),
                            std::string_view(card.http), Blob{card.fingerprint}, Blob{card.token_digest},
                            active ? 1 : 0, for_s);
  const StandbyWork work = work_ ? work_() : StandbyWork();
  if (done && counts_relayed_ && work_)
    done = database_.run(note_relayed, card.id, work.relayed, std::string_view(card.loopback));
  if (done && counts_searched_ && work_)
    done = database_.run(note_searched, card.id, work.searched, work.searches_a, work.searches_b);
  if (done) done = database_.run(forget_those_that_went, gone_after_s);
  if (done) done = database_.settle();
  return done;
}

Result<void> PostgresPresence::look(const ServerCard& card, bool active) {
  std::vector<ServerRecord> seen;
  bool lost = false;  // the mark in the database is not this server's any more
  auto read = database_.each(
      see_all,
      [&](const Row& row) {
        const bool owns = row.integer(3) != 0, is_self = row.integer(4) != 0;
        lost |= active && is_self && !owns;
        if (row.integer(7) != 0 && !owns) return;  // it served, and was killed or cut off: it does not stand by
        std::optional<int> relayed;
        if (!row.is_null(8)) relayed = static_cast<int>(row.integer(8));
        seen.push_back({row.text(0), row.text(1), row.text(2), owns, is_self, row.real(5), std::max(0.0, row.real(6)),
                        relayed, !card.loopback.empty() && row.text(9) == card.loopback,
                        row.is_null(10) ? 0 : row.integer(10), row.integer(11), row.integer(12)});
        if (is_self) counts_relayed_ = relayed.has_value();
        if (is_self) counts_searched_ = !row.is_null(10);
      },
      card.id);
  if (!read) return read;
  {
    const std::lock_guard lock(mutex_);
    seen_ = std::move(seen);
    seen_at_ = Clock::now();
  }
  if (!lost || std::exchange(told_, true)) return {};
  taken_over_({ErrorCode::refused, database_.name() + " was taken over by another headframe-server while this one was "
                                                      "cut off from it; this one serves nobody any more"});
  return {};
}

std::optional<ServerCard> active_server(PostgresDatabase& database) {
  std::optional<ServerCard> card;
  const auto read =
      database.each("SELECT id, name, robots, http, fingerprint, token_digest FROM servers, writer WHERE id = owner",
                    [&](const Row& row) {
                      card = {row.integer(0), row.text(1), row.text(2), row.text(3), row.text(4), row.text(5)};
                    });
  return read ? card : std::nullopt;
}

}  // namespace headframe
