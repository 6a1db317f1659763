#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "server/store/store.hpp"
#include "server/store/store_options.hpp"
#include "server/store/writer_connection.hpp"

namespace headframe {

/// The thread that writes. Writes that arrive within options.group_ms share one commit. A wrong keyframe or cloud fails
/// alone, without affecting the others. If a group fails because of another kind of write, it is halved until that
/// write is alone and fails. A write that the disk refuses waits, and so do all behind it, until there is room; so
/// nothing is confirmed that is not durable. Only LetGo, which makes room, goes before those. If the database itself is
/// at fault (damaged, read-only, another schema), this write and all later ones fail. write() and load() are thread
/// safe.
class StoreWriter {
 public:
  StoreWriter(std::unique_ptr<WriterConnection> connection, const StoreOptions& options);
  ~StoreWriter();  // finishes queued writes; those that the disk refuses then fail

  void write(Write write, Store::Done done);
  StoreLoad load() const;

 private:
  struct Item {
    Write write;
    Store::Done done;
    std::size_t bytes = 0;
    std::optional<Error> wrong = std::nullopt;  // the error found at the last attempt; nothing of it was written
    bool changed_nothing = false;               // at the last attempt: a repetition, or wrong
  };

  void run();
  std::deque<Item> next_group();
  void look_after_connection(std::unique_lock<std::mutex>& lock);
  void commit(std::deque<Item> group);
  Result<void> apply_to_transaction(Item& item);
  Result<void> apply_all(std::deque<Item>& group, std::size_t count);
  Result<void> try_commit(std::deque<Item>& group, std::size_t count);
  bool wait_for_room(const Error& why);
  bool take_what_makes_room(std::deque<Item>& group);
  void finish(Item& item, const Result<void>& committed);
  void give_up(const Error& why);

  std::unique_ptr<WriterConnection> connection_;
  const StoreOptions options_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Item> queue_;
  StoreLoad load_;
  std::optional<Error> broken_;
  bool stopping_ = false;
  int waits_ = 0;  // consecutive ones, without a commit in between
  std::thread thread_;
};

}  // namespace headframe
