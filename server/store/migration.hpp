#pragma once
// Moves a base station's database from SQLite to PostgreSQL or back.

#include <filesystem>
#include <string>

#include "server/store/store_tables.hpp"

namespace headframe {

/// What was copied; it was read back and is identical.
struct Migrated {
  std::uint64_t tables = 0, rows = 0;
};

/// Copies all of `directory`/headframe.db into the database of a postgresql:// URL, in one transaction, so that it
/// arrives completely or not at all. No server may be running on either. Afterwards the file is renamed to
/// headframe.db.moved, so that no server continues with it by mistake; the other files of the directory stay and are
/// still used by the server. not_found: there is no headframe.db; refused: a server uses one of them, or the database
/// belongs to another base station; unavailable, bad_input: errors of the databases; internal: what arrived differs
/// from what was sent.
Result<Migrated> migrate_to_postgres(const std::filesystem::path& directory, const std::string& url,
                                     const TableProgress& progress);

/// The other direction: headframe.db appears in `directory` when it is complete. The data in PostgreSQL stays. refused:
/// there is a headframe.db already, or a server uses one of them.
Result<Migrated> migrate_to_sqlite(const std::string& url, const std::filesystem::path& directory,
                                   const TableProgress& progress);

}  // namespace headframe
