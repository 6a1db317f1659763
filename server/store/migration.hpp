#pragma once
// A base station's database, taken from SQLite to PostgreSQL or back.

#include <filesystem>
#include <string>

#include "server/store/store_tables.hpp"

namespace headframe {

/// What was copied; it was read again where it went, and is the same there.
struct Migrated {
  std::uint64_t tables = 0, rows = 0;
};

/// Copies all of `directory`/headframe.db into the database of a postgresql:// URL, in one transaction: nothing of it
/// is there unless all of it is. No server may run on either. The file is called headframe.db.moved afterwards, so that
/// no server goes on with it by mistake; the other files of the directory stay, and belong to the server as before.
/// not_found: there is no headframe.db; refused: a server uses one of them, or the database holds another base
/// station's; unavailable, bad_input: what the databases say; internal: what arrived is not what was sent.
Result<Migrated> migrate_to_postgres(const std::filesystem::path& directory, const std::string& url,
                                     const TableProgress& progress);

/// The other way round: a headframe.db in `directory` appears when all of it is there. What is in PostgreSQL stays.
/// refused: there is a headframe.db already, or a server uses one of them.
Result<Migrated> migrate_to_sqlite(const std::string& url, const std::filesystem::path& directory,
                                   const TableProgress& progress);

}  // namespace headframe
