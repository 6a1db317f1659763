#pragma once

#include "server/store/database.hpp"

namespace headframe {

/// What the store's writer writes through. Not thread safe.
class WriterConnection {
 public:
  virtual ~WriterConnection() = default;

  virtual Database& database() = 0;

  /// Begins a transaction, on a new connection where the last one was lost. False: none was begun, because the one
  /// before, of whose commit no answer came, is durable.
  virtual Result<bool> begin() = 0;
  /// Success: all of the transaction is durable. A failure whose answer was lost is found out by the next begin().
  virtual Result<void> commit() = 0;
  virtual void rollback() = 0;

  /// Called now and then while nothing is to be written: a connection that was lost meanwhile is made anew, so that no
  /// other server takes the database for abandoned. Errors as begin()'s.
  virtual Result<void> look_after() { return {}; }

  /// The database went away: nothing can be written in whatever portions until begin() succeeds again.
  virtual bool is_lost() const = 0;
};

}  // namespace headframe
