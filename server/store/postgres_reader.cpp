#include "server/store/postgres_reader.hpp"

#include <algorithm>

namespace headframe {
namespace {

constexpr PostgresReader::Clock::duration shortest_pause = std::chrono::milliseconds(100);

}  // namespace

Result<void> PostgresReader::be_connected() {
  if (database_->is_connected()) return {};
  if (Clock::now() < not_before_) return tl::unexpected(last_);
  const auto start = Clock::now();
  auto done = database_->connect();
  if (done) return done;
  last_ = {ErrorCode::unavailable, done.error().message};
  not_before_ = Clock::now() + std::max(shortest_pause, Clock::now() - start);
  return tl::unexpected(last_);
}

Result<void> PostgresReader::execute(const std::string& sql) {
  if (auto there = be_connected(); !there) return there;
  return database_->execute(sql);
}

Result<void> PostgresReader::change(std::string_view, std::span<const SqlValue>, const Changed&) {
  return failure(ErrorCode::internal, "a connection for reading was asked to write");
}

/// That the connection was lost long ago is only noticed by asking: then it is asked once more.
Result<void> PostgresReader::query(std::string_view sql, std::span<const SqlValue> values, const Visit& visit) {
  bool visited = false;
  const auto ask = [&]() -> Result<void> {
    if (auto there = be_connected(); !there) return there;
    return database_->query(sql, values, [&](const Row& row) {
      visited = true;
      visit(row);
    });
  };
  auto done = ask();
  if (!done && !visited && !database_->is_connected() && Clock::now() >= not_before_) done = ask();
  return done;
}

}  // namespace headframe
