#include "server/store/sqlite.hpp"

#include <sqlite3.h>
#include <unistd.h>

#include <limits>

namespace headframe {
namespace {

class SqliteRow final : public Row {
 public:
  explicit SqliteRow(sqlite3_stmt* statement) : statement_(statement) {}
  std::int64_t integer(int column) const override { return sqlite3_column_int64(statement_, column); }
  double real(int column) const override {
    if (is_null(column)) return std::numeric_limits<double>::quiet_NaN();
    return sqlite3_column_double(statement_, column);
  }
  bool is_null(int column) const override { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
  std::string_view blob(int column) const override {
    const auto* data = static_cast<const char*>(sqlite3_column_blob(statement_, column));
    const int bytes = sqlite3_column_bytes(statement_, column);
    return data ? std::string_view(data, static_cast<std::size_t>(bytes)) : std::string_view();
  }

 private:
  sqlite3_stmt* statement_;
};

struct Bind {
  sqlite3_stmt* statement;
  int index;

  void operator()(std::monostate) const { sqlite3_bind_null(statement, index); }
  void operator()(std::int64_t value) const { sqlite3_bind_int64(statement, index, value); }
  void operator()(double value) const { sqlite3_bind_double(statement, index, value); }
  void operator()(std::string_view value) const {
    sqlite3_bind_text(statement, index, there(value), static_cast<int>(value.size()), SQLITE_STATIC);
  }
  void operator()(Blob value) const {
    sqlite3_bind_blob(statement, index, there(value.bytes), static_cast<int>(value.bytes.size()), SQLITE_STATIC);
  }
  static const char* there(std::string_view bytes) { return bytes.data() ? bytes.data() : ""; }  // none would be NULL
};

}  // namespace

void SqliteDatabase::Close::operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }
void SqliteDatabase::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Result<SqliteDatabase> SqliteDatabase::open(const std::string& path) {
  sqlite3* handle = nullptr;
  const int code =
      sqlite3_open_v2(path.c_str(), &handle, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, nullptr);
  SqliteDatabase database(path, handle);
  if (code != SQLITE_OK) return database.fault(code);
  sqlite3_busy_timeout(handle, 5000);
  return database;
}

Result<void> SqliteDatabase::still_there() const {
  int moved = 0;
  const int known = sqlite3_file_control(handle_.get(), "main", SQLITE_FCNTL_HAS_MOVED, &moved);
  const bool log_gone = ::access((path_ + "-wal").c_str(), F_OK) != 0;
  if ((known == SQLITE_OK && moved != 0) || log_gone)
    return failure(ErrorCode::bad_input, path_ + (log_gone ? "-wal" : "") +
                                             " was removed or replaced while the server ran: what comes now can not be "
                                             "kept; put it back and start the server anew");
  return {};
}

Result<void> SqliteDatabase::execute(const std::string& sql) {
  const int code = sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) return fault(code);
  return {};
}

Result<sqlite3_stmt*> SqliteDatabase::prepare(std::string_view sql) {
  auto& kept = statements_[std::string(sql)];
  if (!kept) {
    sqlite3_stmt* made = nullptr;
    const int code = sqlite3_prepare_v3(handle_.get(), sql.data(), static_cast<int>(sql.size()),
                                        SQLITE_PREPARE_PERSISTENT, &made, nullptr);
    if (code != SQLITE_OK) return fault(code);
    kept.reset(made);
  }
  return kept.get();
}

Result<void> SqliteDatabase::query(std::string_view sql, std::span<const SqlValue> values, const Visit& visit) {
  const auto prepared = prepare(sql);
  if (!prepared) return tl::unexpected(prepared.error());
  sqlite3_stmt* statement = *prepared;
  int index = 0;
  for (const SqlValue& value : values) std::visit(Bind{statement, ++index}, value);
  int code = SQLITE_ROW;
  while ((code = sqlite3_step(statement)) == SQLITE_ROW) visit(SqliteRow(statement));
  auto done = code == SQLITE_DONE ? Result<void>{} : Result<void>(fault(code));
  sqlite3_reset(statement);
  sqlite3_clear_bindings(statement);
  return done;
}

Result<void> SqliteDatabase::change(std::string_view sql, std::span<const SqlValue> values, const Changed& changed) {
  auto done = query(sql, values, [](const Row&) {});
  if (done && changed) changed(static_cast<std::uint64_t>(sqlite3_changes(handle_.get())));
  return done;
}

tl::unexpected<Error> SqliteDatabase::fault(int code) const {
  const std::string detail = handle_ ? sqlite3_errmsg(handle_.get()) : sqlite3_errstr(code);
  switch (code & 0xff) {
    case SQLITE_FULL: return failure(ErrorCode::unavailable, path_ + ": the disk is full; make room");
    case SQLITE_CONSTRAINT:
    case SQLITE_TOOBIG: return failure(ErrorCode::invalid_argument, path_ + ": " + detail);
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
      return failure(ErrorCode::bad_input, path_ + " can not be written: " + detail + "; look at its file and disk");
    case SQLITE_IOERR:
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_NOMEM: return failure(ErrorCode::unavailable, path_ + ": " + detail);
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
      return failure(ErrorCode::bad_input, path_ + " is damaged or no headframe database: " + detail +
                                               "; move it away or choose another --data");
    default: return failure(ErrorCode::internal, path_ + ": " + detail);
  }
}

}  // namespace headframe
