#pragma once

#include <chrono>

#include "server/store/postgres.hpp"

namespace headframe {

/// A connection that is only read from: made anew when it was lost, at the next question. While the server does not
/// answer, questions fail (unavailable), most of them at once: it is looked for ten times a second, and at most half of
/// the time.
class PostgresReader final : public Database {
 public:
  using Clock = std::chrono::steady_clock;

  explicit PostgresReader(std::unique_ptr<PostgresDatabase> database) : database_(std::move(database)) {}

  Result<void> execute(const std::string& sql) override;
  Result<void> change(std::string_view sql, std::span<const SqlValue> values, const Changed& changed) override;
  Result<void> query(std::string_view sql, std::span<const SqlValue> values, const Visit& visit) override;
  bool is_connected() const override { return database_->is_connected(); }
  bool answers_from_afar() const override { return true; }
  Result<void> settle() override { return database_->settle(); }

 private:
  Result<void> be_connected();

  std::unique_ptr<PostgresDatabase> database_;
  Clock::time_point not_before_ = {};
  Error last_{};
};

}  // namespace headframe
