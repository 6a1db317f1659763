#pragma once
// A thin coat over SQLite: statements are prepared once and kept, errors are values.

#include <memory>
#include <string>
#include <unordered_map>

#include "server/store/database.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace headframe {

/// Nothing is answered later. bad_input also when the file can not be written. Messages name the file.
class SqliteDatabase final : public Database {
 public:
  static Result<SqliteDatabase> open(const std::string& path);

  /// Whether its file, or its log, still lies where it was opened; else nobody will find again what is written there.
  /// bad_input: it does not.
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
  std::unordered_map<std::string, std::unique_ptr<sqlite3_stmt, Finalize>> statements_;  // gone before handle_
};

}  // namespace headframe
