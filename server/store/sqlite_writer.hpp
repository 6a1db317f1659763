#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>

#include "server/store/sqlite_store.hpp"
#include "server/store/sqlite_writes.hpp"

namespace headframe {

/// The thread that writes. Writes that come within options.group_ms share one commit. A group that fails is halved
/// until what is at fault stands alone: a bad write then fails; one that the disk refuses waits, and all behind it,
/// until there is room, so nothing is answered that is not durable. When the database itself is at fault (damaged,
/// read-only, another schema) trying again is no use: this write and all after it fail. write() and load() are thread
/// safe.
class SqliteWriter {
 public:
  SqliteWriter(Database database, const SqliteOptions& options);
  ~SqliteWriter();  // finishes what is queued; what the disk refuses then fails

  void write(Write write, Store::Done done);
  StoreLoad load() const;

 private:
  struct Item {
    Write write;
    Store::Done done;
    std::size_t bytes = 0;
  };

  void run();
  std::deque<Item> next_group();
  void commit(std::deque<Item> group);
  Result<void> try_commit(const std::deque<Item>& group, std::size_t count);
  bool wait_for_room(const Error& why);
  void finish(Item& item, const Result<void>& result);
  void give_up(const Error& why);

  Database database_;
  const SqliteOptions options_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Item> queue_;
  StoreLoad load_;
  std::optional<Error> broken_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace headframe
