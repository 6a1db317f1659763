#pragma once
// Backs up a running base station to one file, and restores it from one.

#include <filesystem>

#include "common/result.hpp"

namespace headframe {

/// Writes everything that is durable in the database of `directory` to `file` (mode 0600; replaced if it exists),
/// together with the small private files beside it: the server's key, by which the enrolled robots recognise it, the
/// operator's token, the named operators, notes on the map, and revocations that wait for the disk. The server may go
/// on writing; other processes' writes are waited for as usual. Blocks while it copies. not_found: no database;
/// unavailable: no space, or `file` cannot be written; bad_input: the database is damaged. After a failure there is no
/// `file`.
Result<void> write_backup(const std::filesystem::path& directory, const std::filesystem::path& file);

/// Makes `directory` that of a base station in the state of the backup; the next server there updates an older schema.
/// Nothing in `directory` is changed unless all of `file` is valid. refused: there is a database already; not_found,
/// bad_input: `file` does not exist, or is not a complete backup; incompatible: a newer server wrote it; unavailable:
/// the disk failed.
Result<void> restore_backup(const std::filesystem::path& file, const std::filesystem::path& directory);

/// Removes what is left in its directory if a server ended while a backup was being made or sent.
void remove_unfinished_backups(const std::filesystem::path& directory);

}  // namespace headframe
