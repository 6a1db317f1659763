#pragma once
// One file that holds all of a base station, made while it runs, and a base station made from one.

#include <filesystem>

#include "common/result.hpp"

namespace headframe {

/// Writes to `file` (mode 0600; replaced if it is there) all that is durable in the database of `directory` at this
/// moment, and within it the small private files beside it: the server's key, by which the enrolled robots know it, the
/// operator's token, operators by name, notes on the map, and revocations that wait for the disk. The server may go on
/// writing; other processes' writes are waited for as usual. Blocks while it copies. not_found: no database;
/// unavailable: no room, or `file` can not be written; bad_input: the database is damaged. After a failure there is no
/// `file`.
Result<void> write_backup(const std::filesystem::path& directory, const std::filesystem::path& file);

/// Makes `directory` that of a base station as it was when `file` was written; the next server there brings an older
/// schema up. Nothing of `directory` is touched unless all of `file` is sound. refused: a database is there already;
/// not_found, bad_input: `file` is not there, or no whole backup; incompatible: a newer server wrote it; unavailable:
/// the disk says no.
Result<void> restore_backup(const std::filesystem::path& file, const std::filesystem::path& directory);

/// What a server left in its directory that ended while a backup of it was being made or sent.
void remove_unfinished_backups(const std::filesystem::path& directory);

}  // namespace headframe
