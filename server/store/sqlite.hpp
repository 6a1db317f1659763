#pragma once
// A thin wrapper of SQLite: statements are prepared once and kept, errors are values.

#include <memory>
#include <string>
#include <unordered_map>

#include "server/store/database.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace headframe {

/// Every call returns its own result. bad_input also if the file cannot be written. Messages name the file.
class SqliteDatabase final : public Database {
 public:
  static Result<SqliteDatabase> open(const std::string& path);

  /// Checks that the database file and its log are still where they were opened; otherwise what is written is lost.
  /// bad_input: they are not.
  Result<void> still_there() const;

  Result<void> execute(const std::string& sql) override;
  Result<void> change(std::string_view sql, std::span<const SqlValue> values, const Changed& changed) override;
  Result<void> query(std::string_view sql, std::span<const SqlValue> values, const Visit& visit) override;
  bool answers_from_afar() const override { return false; }
  Result<void> settle() override { return {}; }

 private:
  struct Close {
    void operator()(sqlite3* handle) const;
  };
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };

  SqliteDatabase(std::string path, sqlite3* handle) : path_(std::move(path)), handle_(handle) {}
  Result<sqlite3_stmt*> prepare(std::string_view sql);
  tl::unexpected<Error> fault(int code) const;

  std::string path_;
  std::unique_ptr<sqlite3, Close> handle_;
  std::unordered_map<std::string, std::unique_ptr<sqlite3_stmt, Finalize>> statements_;  // destroyed before handle_
};

}  // namespace headframe
