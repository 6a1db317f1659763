#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "server/store/sqlite_store.hpp"
#include "server/store/sqlite_writes.hpp"

namespace headframe {

/// The thread that writes. Writes that come within options.group_ms share one commit; when such a group fails for
/// another reason than the disk, its writes are tried one by one, so that one bad write fails alone. write() and load()
/// are thread safe.
class SqliteWriter {
 public:
  SqliteWriter(Database database, const SqliteOptions& options);
  ~SqliteWriter();  // finishes what is queued

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
  void commit(std::deque<Item>& group);
  Result<void> try_commit(const std::deque<Item>& group);
  void finish(Item& item, const Result<void>& result);

  Database database_;
  const SqliteOptions options_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Item> queue_;
  StoreLoad load_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace headframe
