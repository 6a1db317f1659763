#include "server/store/postgres_pair_work.hpp"

#include <thread>

#include "server/support/parallel.hpp"

namespace headframe {
namespace {

using Clock = std::chrono::steady_clock;

// What was announced of the same data stays as it is, with the result that it may have.
constexpr const char* announce_one =
    "INSERT INTO pair_work (a, b, keyframes_a, keyframes_b, complete_a, complete_b, digest, round, place)"
    " VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9) ON CONFLICT (a, b) DO UPDATE SET keyframes_a = excluded.keyframes_a,"
    " keyframes_b = excluded.keyframes_b, complete_a = excluded.complete_a, complete_b = excluded.complete_b,"
    " digest = excluded.digest, round = excluded.round, place = excluded.place,"
    " result = CASE WHEN pair_work.digest = excluded.digest THEN pair_work.result END,"
    " failed = CASE WHEN pair_work.digest = excluded.digest THEN pair_work.failed ELSE 0 END,"
    " leased_until_s = CASE WHEN pair_work.digest = excluded.digest THEN pair_work.leased_until_s ELSE 0 END";
constexpr const char* forget_the_oldest =
    "DELETE FROM pair_work WHERE id IN (SELECT id FROM pair_work ORDER BY round DESC, place OFFSET ?)";
constexpr const char* take_out =
    "DELETE FROM pair_work WHERE a = ?1 AND b = ?2 AND digest = ?3 AND (result IS NOT NULL OR failed <> 0"
    " OR leased_until_s < extract(epoch FROM clock_timestamp())::float8) RETURNING result";
constexpr const char* is_there = "SELECT 1::bigint FROM pair_work WHERE a = ?1 AND b = ?2 AND digest = ?3";
constexpr const char* claim_first =
    "DELETE FROM pair_work WHERE id = (SELECT id FROM pair_work WHERE result IS NULL AND failed = 0"
    " AND leased_until_s < extract(epoch FROM clock_timestamp())::float8 ORDER BY round DESC, place"
    " FOR UPDATE SKIP LOCKED LIMIT 1)"
    " RETURNING a, b, keyframes_a, keyframes_b, complete_a, complete_b, digest";
constexpr const char* lease_first =
    "UPDATE pair_work SET taken_by = ?1, leased_until_s = extract(epoch FROM clock_timestamp())::float8 + ?2"
    " WHERE id = (SELECT id FROM pair_work WHERE result IS NULL AND failed = 0"
    " AND leased_until_s < extract(epoch FROM clock_timestamp())::float8 ORDER BY round DESC, place"
    " FOR UPDATE SKIP LOCKED LIMIT 1)"
    " RETURNING a, b, keyframes_a, keyframes_b, complete_a, complete_b, digest";
constexpr const char* put_result = "UPDATE pair_work SET result = ?4 WHERE a = ?1 AND b = ?2 AND digest = ?3";
constexpr const char* put_failed = "UPDATE pair_work SET failed = 1 WHERE a = ?1 AND b = ?2 AND digest = ?3";

PairTask task_of(const Row& row) {
  return {row.integer(0),
          row.integer(1),
          static_cast<std::uint64_t>(row.integer(2)),
          static_cast<std::uint64_t>(row.integer(3)),
          row.integer(4) != 0,
          row.integer(5) != 0,
          row.text(6)};
}

}  // namespace

Result<PostgresDatabase*> PairWorkTable::connected() {
  if (database_.is_connected()) return &database_;
  if (Clock::now() < not_before_) return failure(ErrorCode::unavailable, database_.name() + " is away");
  not_before_ = Clock::now() + look_every;
  auto done = database_.connect();
  if (done) done = database_.execute("SET synchronous_commit = off; LISTEN " + listens_to_);
  if (!done) return tl::unexpected(done.error());
  is_new_ = true;
  return &database_;
}

void PostgresPairHelpers::announce(const std::vector<PairTask>& tasks) {
  const auto database = table_.connected();
  if (!database) return;
  PostgresDatabase& db = **database;
  Result<void> done;
  if (table_.is_new()) done = db.run("DELETE FROM pair_work");  // of an earlier active server
  ++round_;
  std::int64_t place = 0;
  for (const PairTask& task : tasks)
    if (done)
      done = db.run(announce_one, task.a, task.b, task.keyframes_a, task.keyframes_b, task.complete_a ? 1 : 0,
                    task.complete_b ? 1 : 0, Blob{task.digest}, round_, place++);
  if (done) done = db.run(forget_the_oldest, std::int64_t{most_rows});
  if (done) done = db.run("NOTIFY headframe_pair_asked");
  if (done) done = db.settle();
}

PairHelpers::Answer PostgresPairHelpers::ask(const PairTask& task) {
  const auto database = table_.connected();
  if (!database) return {};
  Answer answer;
  bool out = false;
  auto read = (*database)->each(
      take_out,
      [&](const Row& row) {
        out = true;
        if (!row.is_null(0)) answer = {Turn::done, row.text(0)};
      },
      task.a, task.b, Blob{task.digest});
  if (!read || out) return answer;
  read = (*database)->each(
      is_there, [&](const Row&) { answer.turn = Turn::others; }, task.a, task.b, Blob{task.digest});
  return read ? answer : Answer();
}

std::optional<PairTask> PostgresPairHelpers::claim() {
  const auto database = table_.connected();
  if (!database) return std::nullopt;
  std::optional<PairTask> task;
  (void)(*database)->each(claim_first, [&](const Row& row) { task = task_of(row); });
  return task;
}

PairHelpers::Answer PostgresPairHelpers::wait(const PairTask& task) {
  constexpr auto look_for_end = std::chrono::milliseconds(100);  // of the caller's work
  const std::atomic<bool>* const cancelled = Cancellable::flag();
  auto look_at = Clock::now();
  while (true) {
    if (cancelled != nullptr && *cancelled) throw Cancelled();
    bool looks = Clock::now() >= look_at;
    if (!looks) {
      const auto database = table_.connected();
      const auto noticed = database ? (*database)->wait_for_notice(look_for_end) : Result<bool>(true);
      looks = !noticed || *noticed;
    }
    if (!looks) continue;
    look_at = Clock::now() + PairWorkTable::look_every;
    if (Answer answer = ask(task); answer.turn != Turn::others) return answer;
  }
}

void PostgresPairHelpers::withdraw(const std::vector<PairTask>& tasks) {
  const auto database = table_.connected();
  if (!database) return;
  Result<void> done;
  for (const PairTask& task : tasks)
    if (done)
      done = (*database)->run("DELETE FROM pair_work WHERE a = ? AND b = ? AND digest = ?", task.a, task.b,
                              Blob{task.digest});
  if (done) done = (*database)->settle();
}

std::optional<PairTask> PostgresPairQueue::take() {
  const auto database = table_.connected();
  if (!database) return std::nullopt;
  std::optional<PairTask> task;
  (void)(*database)->each(
      lease_first, [&](const Row& row) { task = task_of(row); }, self_, lease_s_);
  return task;
}

void PostgresPairQueue::answer(const PairTask& task, const std::string& result) {
  const auto database = table_.connected();
  if (!database) return;  // the lease ends
  auto done = result.empty() ? (*database)->run(put_failed, task.a, task.b, Blob{task.digest})
                             : (*database)->run(put_result, task.a, task.b, Blob{task.digest}, Blob{result});
  if (done) done = (*database)->run("NOTIFY headframe_pair_found");
  if (done) done = (*database)->settle();
}

bool PostgresPairQueue::wait(std::chrono::milliseconds most) {
  const auto database = table_.connected();
  if (database) return (*database)->wait_for_notice(most).value_or(false);
  std::this_thread::sleep_for(most);
  return false;
}

}  // namespace headframe
