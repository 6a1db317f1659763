#include "server/store/postgres.hpp"

#include <libpq-fe.h>
#include <poll.h>

#include <algorithm>
#include <cstdlib>

#include "server/store/postgres_values.hpp"

namespace headframe {
namespace {

constexpr int silence_ms = 30'000;                          // of a server that was asked
constexpr std::size_t sent_most = 2000;                     // statements that may be on the way without an answer,
constexpr std::size_t sent_bytes_most = 8UL * 1024 * 1024;  // ... and their values

void say_nothing(void*, const PGresult*) {}

}  // namespace

void PostgresDatabase::Finish::operator()(pg_conn* connection) const { PQfinish(connection); }
void PostgresDatabase::Clear::operator()(pg_result* result) const { PQclear(result); }

PostgresDatabase::PostgresDatabase(std::string url, std::string name) : url_(std::move(url)), name_(std::move(name)) {}
PostgresDatabase::~PostgresDatabase() = default;

Result<void> PostgresDatabase::connect() {
  connection_.reset();
  prepared_.clear();
  sent_.clear();
  sent_bytes_ = 0;
  first_fault_.reset();
  if (auto reached = reach(); !reached) return reached;
  PQsetNoticeReceiver(connection_.get(), say_nothing, nullptr);
  if (PQsetnonblocking(connection_.get(), 1) != 0) return lost("it can not be waited for");
  auto fit = make_fit();
  if (!fit) connection_.reset();
  return fit;
}

Result<void> PostgresDatabase::execute(const std::string& sql) {
  if (auto settled = settle(); !settled) return settled;
  if (PQsendQuery(connection_.get(), sql.c_str()) != 1) return lost(PQerrorMessage(connection_.get()));
  return finish([](const Row&) {});
}

Result<void> PostgresDatabase::query(std::string_view sql, std::span<const SqlValue> values, const Visit& visit) {
  const PostgresValues bound(values);
  if (auto settled = settle(); !settled) return settled;
  const auto name = known_as(sql, bound);
  if (!name) return tl::unexpected(name.error());
  if (PQsendQueryPrepared(connection_.get(), name->c_str(), bound.count(), bound.data.data(), bound.lengths.data(),
                          bound.formats.data(), 1) != 1)
    return lost(PQerrorMessage(connection_.get()));
  PQsetSingleRowMode(connection_.get());
  return finish(visit);
}

/// The name under which the server knows the statement. In pipeline mode it is prepared by the next settle().
Result<std::string> PostgresDatabase::known_as(std::string_view sql, const PostgresValues& values) {
  std::string statement(sql);
  if (const auto known = prepared_.find(statement); known != prepared_.end()) return known->second;
  const std::string name = "s" + std::to_string(++names_), numbered = with_numbered_values(sql);
  if (PQsendPrepare(connection_.get(), name.c_str(), numbered.c_str(), values.count(), values.types.data()) != 1)
    return lost(PQerrorMessage(connection_.get()));
  if (PQpipelineStatus(connection_.get()) != PQ_PIPELINE_OFF)
    sent_.push_back({statement, {}});
  else if (auto told = finish([](const Row&) {}); !told)
    return tl::unexpected(told.error());
  prepared_.emplace(std::move(statement), name);
  return name;
}

Result<void> PostgresDatabase::change(std::string_view sql, std::span<const SqlValue> values, const Changed& changed) {
  if (!connection_) return lost("the connection is lost");
  const PostgresValues bound(values);
  if (sent_.size() >= sent_most || sent_bytes_ + bound.bytes > sent_bytes_most)
    if (auto settled = settle(); !settled) return settled;
  if (sent_.empty() && PQenterPipelineMode(connection_.get()) != 1) return lost(PQerrorMessage(connection_.get()));
  const auto name = known_as(sql, bound);
  if (!name) return tl::unexpected(name.error());
  if (PQsendQueryPrepared(connection_.get(), name->c_str(), bound.count(), bound.data.data(), bound.lengths.data(),
                          bound.formats.data(), 1) != 1)
    return lost(PQerrorMessage(connection_.get()));
  sent_.push_back({{}, changed});
  sent_bytes_ += bound.bytes;
  return {};
}

Result<void> PostgresDatabase::settle() {
  if (!connection_) return lost("the connection is lost");
  if (sent_.empty()) return {};
  if (PQpipelineSync(connection_.get()) != 1) return lost(PQerrorMessage(connection_.get()));
  bool synchronised = false;
  for (bool answered = false; !synchronised;) {
    auto result = next_result();
    if (!result) return tl::unexpected(result.error());
    const auto status = *result ? PQresultStatus(result->get()) : PGRES_EMPTY_QUERY;
    synchronised = status == PGRES_PIPELINE_SYNC;
    if (!*result && !answered) return lost("it answers out of turn");
    if (*result && !synchronised) take_answer(sent_.front(), result->get());
    if (!*result) sent_.pop_front();
    answered = static_cast<bool>(*result);
    if (!connection_) return tl::unexpected(*first_fault_);
  }
  sent_.clear();
  sent_bytes_ = 0;
  if (PQexitPipelineMode(connection_.get()) != 1) return lost(PQerrorMessage(connection_.get()));
  if (!first_fault_) return {};
  const Error why = *std::exchange(first_fault_, std::nullopt);
  return tl::unexpected(why);
}

void PostgresDatabase::take_answer(Sent& of, const pg_result* result) {
  const auto status = PQresultStatus(result);
  const bool good = status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK;
  if (good && of.changed) of.changed(std::strtoull(PQcmdTuples(const_cast<pg_result*>(result)), nullptr, 10));
  if (good) return;
  prepared_.erase(of.prepares);
  if (status != PGRES_PIPELINE_ABORTED && !first_fault_) first_fault_ = fault(result).value();
}

/// Reads all results of what was sent outside pipeline mode.
Result<void> PostgresDatabase::finish(const Visit& visit) {
  Result<void> done;
  while (true) {
    auto result = next_result();
    if (!result) return tl::unexpected(result.error());
    if (!*result) return done;
    const auto status = PQresultStatus(result->get());
    if (status == PGRES_FATAL_ERROR || status == PGRES_BAD_RESPONSE) {
      if (done) done = fault(result->get());
      if (!connection_) return done;
    }
    for (int row = 0; done && row < PQntuples(result->get()); ++row) visit(PostgresRow(result->get(), row));
  }
}

Result<void> PostgresDatabase::wait(bool to_write) {
  pollfd waiting{PQsocket(connection_.get()), static_cast<short>(to_write ? POLLIN | POLLOUT : POLLIN), 0};
  int ready = 0;
  do ready = ::poll(&waiting, 1, silence_ms);
  while (ready < 0 && errno == EINTR);
  if (ready <= 0) return lost("it says nothing for " + std::to_string(silence_ms / 1000) + " s");
  if ((waiting.revents & ~POLLOUT) != 0 && PQconsumeInput(connection_.get()) != 1)
    return lost(PQerrorMessage(connection_.get()));
  return {};
}

Result<bool> PostgresDatabase::wait_for_notice(std::chrono::milliseconds most) {
  if (auto settled = settle(); !settled) return tl::unexpected(settled.error());
  const auto noticed = [&] {
    bool any = false;
    for (PGnotify* one = nullptr; (one = PQnotifies(connection_.get())) != nullptr; PQfreemem(one)) any = true;
    return any;
  };
  if (noticed()) return true;
  pollfd waiting{PQsocket(connection_.get()), POLLIN, 0};
  if (::poll(&waiting, 1, static_cast<int>(most.count())) <= 0) return false;
  if (PQconsumeInput(connection_.get()) != 1) return lost(PQerrorMessage(connection_.get()));
  return noticed();
}

/// Reads answers meanwhile, so that neither side blocks because the other does not read.
Result<void> PostgresDatabase::push_out() {
  int left = 0;
  while ((left = PQflush(connection_.get())) > 0)
    if (auto ready = wait(true); !ready) return ready;
  if (left < 0) return lost(PQerrorMessage(connection_.get()));
  return {};
}

Result<PostgresDatabase::PgResult> PostgresDatabase::next_result() {
  if (auto sent = push_out(); !sent) return tl::unexpected(sent.error());
  while (PQisBusy(connection_.get()) != 0)
    if (auto ready = wait(false); !ready) return tl::unexpected(ready.error());
  return PgResult(PQgetResult(connection_.get()));
}

}  // namespace headframe
