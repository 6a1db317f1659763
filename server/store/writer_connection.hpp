#pragma once

#include "server/store/database.hpp"

namespace headframe {

/// The connection used by the store's writer. Not thread safe.
class WriterConnection {
 public:
  virtual ~WriterConnection() = default;

  virtual Database& database() = 0;

  /// Begins a transaction, on a new connection if the last one was lost. Returns false, and begins none, if the
  /// previous transaction, whose commit was not answered, turns out to be durable.
  virtual Result<bool> begin() = 0;
  /// Success: all of the transaction is durable. If the answer to a commit was lost, the next begin() finds out what
  /// happened.
  virtual Result<void> commit() = 0;
  virtual void rollback() = 0;

  /// Called from time to time while there is nothing to write: restores a lost connection, so that no other server
  /// takes the database for abandoned. Fails like begin().
  virtual Result<void> look_after() { return {}; }

  /// Whether the database is unreachable: then nothing can be written, in portions of any size, until begin() succeeds
  /// again.
  virtual bool is_lost() const = 0;
};

}  // namespace headframe
