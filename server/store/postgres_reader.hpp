#pragma once

#include <chrono>

#include "server/store/postgres.hpp"

namespace headframe {

/// A connection for reading, which the next query restores if it was lost. While the database does not answer, queries
/// fail (unavailable), most of them at once: attempts to connect are at least 100 ms apart, and at least as long apart
/// as the last one took.
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
