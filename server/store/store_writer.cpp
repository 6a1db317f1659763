#include "server/store/store_writer.hpp"

#include <algorithm>

#include "server/store/store_writes.hpp"

namespace headframe {
namespace {

constexpr auto look_after_every = std::chrono::seconds(1);  // while nothing is to be written
constexpr std::size_t group_bytes = 8UL * 1024 * 1024;      // limit of a commit, so that acknowledgements keep flowing

/// Whether the fault is the database's, not that of one write or of the disk for now.
bool is_of_the_database(const Error& error) {
  return error.code == ErrorCode::bad_input || error.code == ErrorCode::internal;
}

/// Whether the write is a single statement: if it fails, nothing of it was written, and the transaction may go on.
bool is_one_statement(const Write& write) {
  return std::holds_alternative<PutKeyframe>(write) || std::holds_alternative<PutCloud>(write);
}

bool makes_room(const Write& write) { return std::holds_alternative<LetGo>(write); }

}  // namespace

StoreWriter::StoreWriter(std::unique_ptr<WriterConnection> connection, const StoreOptions& options)
    : connection_(std::move(connection)), options_(options) {
  load_.queue_bytes = options.queue_bytes;
  thread_ = std::thread([this] { run(); });
}

StoreWriter::~StoreWriter() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void StoreWriter::write(Write write, Store::Done done) {
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

StoreLoad StoreWriter::load() const {
  const std::lock_guard lock(mutex_);
  return load_;
}

void StoreWriter::run() {
  while (true) {
    auto group = next_group();
    if (group.empty()) return;
    commit(std::move(group));
  }
}

std::deque<StoreWriter::Item> StoreWriter::next_group() {
  std::unique_lock lock(mutex_);
  const auto has_come = [&] { return stopping_ || !queue_.empty(); };
  while (!wake_.wait_for(lock, look_after_every, has_come)) look_after_connection(lock);
  wake_.wait_for(lock, std::chrono::milliseconds(options_.group_ms),
                 [&] { return stopping_ || load_.queued_bytes >= group_bytes; });
  std::deque<Item> group;
  for (std::size_t bytes = 0; !queue_.empty() && bytes < group_bytes; queue_.pop_front()) {
    bytes += queue_.front().bytes;
    group.push_back(std::move(queue_.front()));
  }
  std::stable_partition(group.begin(), group.end(), [](const Item& item) { return makes_room(item.write); });
  return group;
}

void StoreWriter::look_after_connection(std::unique_lock<std::mutex>& lock) {
  if (broken_) return;
  lock.unlock();
  const auto well = connection_->look_after();
  if (!well && is_of_the_database(well.error())) give_up(well.error());
  lock.lock();
}

void StoreWriter::commit(std::deque<Item> group) {
  for (std::size_t count = group.size(); !group.empty();) {
    const auto done = broken_ ? Result<void>(tl::unexpected(*broken_)) : try_commit(group, count);
    const bool disk = !done && done.error().code == ErrorCode::unavailable;
    if (!done && is_of_the_database(done.error())) {
      give_up(done.error());
    } else if (!done && count > 1 && !connection_->is_lost()) {
      count /= 2;
      continue;
    }
    if (disk && wait_for_room(done.error())) {
      if (take_what_makes_room(group)) count = 1;
      continue;
    }
    for (; count > 0; --count, group.pop_front()) finish(group.front(), done);
    count = group.size();
  }
}

Result<void> StoreWriter::apply_to_transaction(Item& item) {
  item.wrong.reset();
  item.changed_nothing = false;
  auto done = headframe::apply(connection_->database(), item.write,  // not std::apply
                               [&item](std::uint64_t rows) { item.changed_nothing = rows == 0; });
  if (done || !is_one_statement(item.write) || done.error().code == ErrorCode::unavailable ||
      is_of_the_database(done.error()))
    return done;
  item.wrong = std::move(done.error());
  return {};
}

Result<void> StoreWriter::apply_all(std::deque<Item>& group, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    if (auto done = apply_to_transaction(group[i]); !done) return done;
  if (auto done = connection_->database().settle(); !done) return done;
  for (std::size_t i = 0; i < count; ++i) {
    if (!group[i].changed_nothing) continue;
    auto right = why_nothing_changed(connection_->database(), group[i].write);
    if (right) continue;
    if (right.error().code == ErrorCode::unavailable || is_of_the_database(right.error())) return right;
    group[i].wrong = std::move(right.error());
  }
  return {};
}

Result<void> StoreWriter::try_commit(std::deque<Item>& group, std::size_t count) {
  const auto start = std::chrono::steady_clock::now();
  const auto begun = connection_->begin();
  if (!begun) return tl::unexpected(begun.error());
  if (*begun) {
    auto done = apply_all(group, count);
    if (done) done = connection_->commit();
    if (!done) {
      connection_->rollback();
      return done;
    }
  }
  waits_ = 0;
  const std::lock_guard lock(mutex_);
  ++load_.commits;
  load_.commit_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return {};
}

/// Returns false if the store is closing.
bool StoreWriter::wait_for_room(const Error& why) {
  const int doubled = options_.retry_ms << std::min(waits_++, 10);
  const std::chrono::milliseconds pause(std::clamp(doubled, options_.retry_ms, options_.longest_retry_ms));
  std::unique_lock lock(mutex_);
  load_.waits_for = load_.last_error = why.message;
  return !wake_.wait_for(lock, pause, [&] { return stopping_; });
}

/// Takes a write that makes room, although others that wait came earlier. Returns false if there is none.
bool StoreWriter::take_what_makes_room(std::deque<Item>& group) {
  const std::lock_guard lock(mutex_);
  const auto found =
      std::find_if(queue_.begin(), queue_.end(), [](const Item& item) { return makes_room(item.write); });
  if (found == queue_.end()) return false;
  group.push_front(std::move(*found));
  queue_.erase(found);
  return true;
}

/// Makes this and all later writes fail. broken_ is set only here, on the writer's thread, which therefore reads it
/// without the lock.
void StoreWriter::give_up(const Error& why) {
  if (broken_) return;
  const std::lock_guard lock(mutex_);
  broken_ = why;
  load_.broken = why.message;
}

void StoreWriter::finish(Item& item, const Result<void>& committed) {
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
