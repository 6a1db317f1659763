// What PostgreSQL's errors mean for the store, and what a server has to be for its commits to be believed.
#include <libpq-fe.h>

#include <algorithm>
#include <array>

#include "server/store/postgres.hpp"

namespace headframe {
namespace {

/// One line, as messages are.
std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::replace(text.begin(), text.end(), '\t', ' ');
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

/// By SQLSTATE: its class are the first two letters. The appendix of PostgreSQL's manual lists them.
ErrorCode code_of(std::string_view state) {
  const std::string_view state_class = state.substr(0, 2);
  const auto is_one_of = [](std::string_view what, std::initializer_list<std::string_view> all) {
    return std::find(all.begin(), all.end(), what) != all.end();
  };
  if (is_one_of(state_class, {"08", "53", "57", "58"}))
    return ErrorCode::unavailable;  // no link, disk, memory; told to stop
  if (is_one_of(state, {"40001", "40P01", "55P03", "25006"}))
    return ErrorCode::unavailable;                                                     // another's lock; a standby
  if (is_one_of(state_class, {"22", "23", "54"})) return ErrorCode::invalid_argument;  // value, constraint, too large
  if (is_one_of(state_class, {"28", "3D", "3F", "42", "XX"})) return ErrorCode::bad_input;  // rights, no table, damaged
  return ErrorCode::internal;
}

/// The server ends the connection with it, or is about to.
bool ends_connection(std::string_view state) { return state.substr(0, 4) == "57P0" || state.substr(0, 2) == "08"; }

}  // namespace

Result<std::string> postgres_name(const std::string& url) {
  char* error = nullptr;
  PQconninfoOption* options = PQconninfoParse(url.c_str(), &error);
  if (options == nullptr) {
    const std::string why = one_line(error != nullptr ? error : "out of memory");
    PQfreemem(error);
    return failure(ErrorCode::bad_input, "the database's URL is not understood: " + why +
                                             "; it is written postgresql://USER@HOST:PORT/DATABASE");
  }
  std::string host, database;
  for (const PQconninfoOption* option = options; option->keyword != nullptr; ++option) {
    const std::string_view keyword = option->keyword;
    if (option->val == nullptr) continue;
    if (keyword == "host") host = option->val;
    if (keyword == "dbname") database = option->val;
  }
  PQconninfoFree(options);
  return "PostgreSQL" + (database.empty() ? "" : ", database " + database) + (host.empty() ? "" : " on " + host);
}

tl::unexpected<Error> PostgresDatabase::lost(const std::string& why) {
  const Error error{ErrorCode::unavailable, name_ + ": " + one_line(why)};
  connection_.reset();
  return tl::unexpected(error);
}

tl::unexpected<Error> PostgresDatabase::fault(const pg_result* result) {
  const char* field = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  const std::string state = field != nullptr ? field : "";
  const std::string why = PQresultErrorMessage(result);
  if (PQstatus(connection_.get()) == CONNECTION_BAD || ends_connection(state) || state.empty()) return lost(why);
  return failure(code_of(state), name_ + ": " + one_line(why));
}

/// A server that is there and does not have us is asked twice: it may just have started.
Result<void> PostgresDatabase::reach() {
  constexpr std::array keywords{"connect_timeout",
                                "application_name",
                                "keepalives_idle",
                                "keepalives_interval",
                                "keepalives_count",
                                "tcp_user_timeout",
                                "dbname",
                                "client_encoding",
                                static_cast<const char*>(nullptr)};
  const std::array values{
      "5", "headframe-server", "10", "5", "3", "20000", url_.c_str(), "UTF8", static_cast<const char*>(nullptr)};
  for (int attempt = 0;; ++attempt) {
    connection_.reset(PQconnectdbParams(keywords.data(), values.data(), 1));
    if (PQstatus(connection_.get()) == CONNECTION_OK) return {};
    const PGPing answer = PQpingParams(keywords.data(), values.data(), 1);
    const auto away = lost(PQerrorMessage(connection_.get()));
    if (answer == PQPING_NO_RESPONSE || answer == PQPING_REJECT) return away;
    if (attempt > 0 || answer == PQPING_NO_ATTEMPT) return failure(ErrorCode::bad_input, away.value().message);
  }
}

Result<void> PostgresDatabase::make_fit() {
  bool syncs = false, waits = false, standby = true;
  std::int64_t version = 0;
  std::string encoding;
  auto read = each(
      "SELECT current_setting('fsync') = 'on', current_setting('synchronous_commit') <> 'off', pg_is_in_recovery(),"
      " current_setting('server_version_num')::bigint, current_setting('server_encoding')",
      [&](const Row& row) {
        syncs = row.integer(0) != 0, waits = row.integer(1) != 0, standby = row.integer(2) != 0;
        version = row.integer(3), encoding = row.text(4);
      });
  if (!read) return read;
  if (standby) return failure(ErrorCode::unavailable, name_ + " is a standby, which can not be written");
  if (version < 120000) return failure(ErrorCode::bad_input, name_ + " is older than PostgreSQL 12");
  if (encoding != "UTF8")
    return failure(ErrorCode::bad_input,
                   name_ + " has the encoding " + encoding + "; make one with ENCODING 'UTF8' TEMPLATE template0");
  if (!syncs)
    return failure(ErrorCode::bad_input,
                   name_ + " runs with fsync off, and a power cut would take what was acknowledged; set fsync = on");
  return execute(std::string(waits ? "" : "SET synchronous_commit = on;") +
                 "SET search_path = headframe; SET statement_timeout = 0; SET lock_timeout = 0;"
                 "SET idle_in_transaction_session_timeout = 0; SET tcp_keepalives_idle = 10;"
                 "SET tcp_keepalives_interval = 5; SET tcp_keepalives_count = 3");
}

}  // namespace headframe
