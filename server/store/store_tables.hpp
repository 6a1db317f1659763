#pragma once
// The columns of all tables, independent of the database, for copying and comparing them.

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "server/store/database.hpp"

namespace headframe {

/// Each column of a table is one word, whose last letter gives its type: # integer, ~ real, $ text, & blob.
struct StoreTable {
  std::string_view name, columns;
};

/// All tables of the store; those that others refer to come first.
const std::vector<StoreTable>& store_tables();
/// The names of the columns, without types.
std::vector<std::string> column_names(const StoreTable& table);

/// The number of rows of a table, and a sum over them that does not depend on their order.
struct TableSum {
  std::uint64_t rows = 0, checksum = 0;
  bool operator==(const TableSum&) const = default;
};
using TableSums = std::map<std::string, TableSum>;

/// Called before the first row of a table, from time to time, and after its last row.
using TableProgress = std::function<void(std::string_view table, std::uint64_t rows, std::uint64_t of)>;

/// Reads all tables. Fails like the database.
Result<TableSums> sum_tables(Database& database, const TableProgress& progress);
/// The same, and also writes every row to the tables of `to`, in a transaction that the caller has begun there.
Result<TableSums> copy_tables(Database& from, Database& to, const TableProgress& progress);

}  // namespace headframe
