#include "server/store/sqlite_writer.hpp"

namespace headframe {
namespace {

constexpr std::size_t group_bytes = 8UL * 1024 * 1024;  // a commit no greater than this, so that acks keep flowing

/// Not one write, nor the disk for now.
bool is_of_the_database(const Error& error) {
  return error.code == ErrorCode::bad_input || error.code == ErrorCode::internal;
}

/// One statement: where it fails, nothing of it was written, and the transaction may go on.
bool is_one_statement(const Write& write) {
  return std::holds_alternative<PutKeyframe>(write) || std::holds_alternative<PutCloud>(write);
}

}  // namespace

SqliteWriter::SqliteWriter(Database database, const SqliteOptions& options)
    : database_(std::move(database)), options_(options) {
  load_.queue_bytes = options.queue_bytes;
  thread_ = std::thread([this] { run(); });
}

SqliteWriter::~SqliteWriter() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void SqliteWriter::write(Write write, Store::Done done) {
  Item item{std::move(write), std::move(done), 0};
  item.bytes = size_bytes(item.write);
  Error why{ErrorCode::unavailable, "the store can not keep up: " + std::to_string(options_.queue_bytes) +
                                        " bytes wait to be written; try again later"};
  {
    const std::lock_guard lock(mutex_);
    if (broken_) why = *broken_;
    if (!broken_ && load_.queued_bytes + item.bytes <= options_.queue_bytes) {
      load_.queued_bytes += item.bytes;
      ++load_.queued_writes;
      queue_.push_back(std::move(item));
      wake_.notify_all();
      return;
    }
    ++load_.failed_writes;
  }
  item.done(tl::unexpected(std::move(why)));
}

StoreLoad SqliteWriter::load() const {
  const std::lock_guard lock(mutex_);
  return load_;
}

void SqliteWriter::run() {
  while (true) {
    auto group = next_group();
    if (group.empty()) return;
    commit(std::move(group));
  }
}

std::deque<SqliteWriter::Item> SqliteWriter::next_group() {
  std::unique_lock lock(mutex_);
  wake_.wait(lock, [&] { return stopping_ || !queue_.empty(); });
  wake_.wait_for(lock, std::chrono::milliseconds(options_.group_ms),
                 [&] { return stopping_ || load_.queued_bytes >= group_bytes; });
  std::deque<Item> group;
  for (std::size_t bytes = 0; !queue_.empty() && bytes < group_bytes; queue_.pop_front()) {
    bytes += queue_.front().bytes;
    group.push_back(std::move(queue_.front()));
  }
  return group;
}

void SqliteWriter::commit(std::deque<Item> group) {
  for (std::size_t count = group.size(); !group.empty();) {
    const auto done = broken_ ? Result<void>(tl::unexpected(*broken_)) : try_commit(group, count);
    const bool disk = !done && done.error().code == ErrorCode::unavailable;
    if (!done && is_of_the_database(done.error())) {
      give_up(done.error());
    } else if (!done && count > 1) {
      count /= 2;
      continue;
    }
    if (disk && wait_for_room(done.error())) continue;
    for (; count > 0; --count, group.pop_front()) finish(group.front(), done);
    count = group.size();
  }
}

Result<void> SqliteWriter::apply_to_transaction(Item& item) {
  item.wrong.reset();
  auto done = headframe::apply(database_, item.write);  // not std::apply
  if (done || !is_one_statement(item.write) || done.error().code == ErrorCode::unavailable ||
      is_of_the_database(done.error()))
    return done;
  item.wrong = std::move(done.error());
  return {};
}

Result<void> SqliteWriter::try_commit(std::deque<Item>& group, std::size_t count) {
  const auto start = std::chrono::steady_clock::now();
  auto done = database_.execute("BEGIN IMMEDIATE");
  for (std::size_t i = 0; done && i < count; ++i) done = apply_to_transaction(group[i]);
  if (done) done = database_.execute("COMMIT");
  if (!done) {
    (void)database_.execute("ROLLBACK");
    return done;
  }
  if (done = database_.still_there(); !done) return done;
  const std::lock_guard lock(mutex_);
  ++load_.commits;
  load_.commit_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return done;
}

/// False: the store closes.
bool SqliteWriter::wait_for_room(const Error& why) {
  std::unique_lock lock(mutex_);
  load_.waits_for = load_.last_error = why.message;
  return !wake_.wait_for(lock, std::chrono::milliseconds(options_.retry_ms), [&] { return stopping_; });
}

/// From now on. broken_ is only set here, on the writer's thread, which therefore reads it without the lock.
void SqliteWriter::give_up(const Error& why) {
  if (broken_) return;
  const std::lock_guard lock(mutex_);
  broken_ = why;
  load_.broken = why.message;
}

void SqliteWriter::finish(Item& item, const Result<void>& committed) {
  const Result<void> result = committed && item.wrong ? Result<void>(tl::unexpected(*item.wrong)) : committed;
  {
    const std::lock_guard lock(mutex_);
    --load_.queued_writes;
    load_.queued_bytes -= item.bytes;
    ++(result ? load_.durable_writes : load_.failed_writes);
    load_.last_error = result ? std::string() : result.error().message;
    load_.waits_for.clear();
  }
  item.done(result);
}

}  // namespace headframe
