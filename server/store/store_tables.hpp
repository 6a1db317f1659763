#pragma once
// What the tables hold, whichever database they are in: to copy and to compare them.

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "server/store/database.hpp"

namespace headframe {

/// Of a table's columns each is one word, and its last letter says what it holds: # a whole number, ~ a real one, $
/// text, & a blob.
struct StoreTable {
  std::string_view name, columns;
};

/// All that a store keeps, those that are referred to first.
const std::vector<StoreTable>& store_tables();
/// Their names, without what they hold.
std::vector<std::string> column_names(const StoreTable& table);

/// How many rows a table has, and a sum over them that does not depend on their order.
struct TableSum {
  std::uint64_t rows = 0, checksum = 0;
  bool operator==(const TableSum&) const = default;
};
using TableSums = std::map<std::string, TableSum>;

/// Told before the first row of a table, now and then, and after its last.
using TableProgress = std::function<void(std::string_view table, std::uint64_t rows, std::uint64_t of)>;

/// Reads all tables. The database's own errors.
Result<TableSums> sum_tables(Database& database, const TableProgress& progress);
/// The same, and writes every row to the tables of `to`, within the transaction that the caller has begun there.
Result<TableSums> copy_tables(Database& from, Database& to, const TableProgress& progress);

}  // namespace headframe
