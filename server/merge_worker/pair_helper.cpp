#include "server/merge_worker/pair_helper.hpp"

#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <utility>

#include "server/merge_worker/pair_replica.hpp"
#include "server/store/postgres_reader.hpp"
#include "server/support/parallel.hpp"

namespace headframe {

PairHelper::PairHelper(const std::string& url, const std::string& database, std::int64_t self,
                       const MergeConfig& config)
    : url_(url), database_(database), self_(self), config_(config), thread_([this] { run(); }) {}

PairHelper::~PairHelper() {
  stop();
  thread_.join();
}

PairHelper::Work PairHelper::work() const {
  const std::lock_guard lock(mutex_);
  return work_;
}

void PairHelper::run() {
  constexpr int as_merging_nice = 10;
  constexpr auto look_for_end = std::chrono::milliseconds(100);
  (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), as_merging_nice);
  const Cancellable cancellable(stops_);
  PostgresPairQueue queue(url_, database_, self_);
  PostgresReader reader(std::make_unique<PostgresDatabase>(url_, database_));
  PairReplica replica(config_, reader);
  auto look_at = std::chrono::steady_clock::now();
  while (!stops_) {
    // A notice that comes while a pair is searched is seen afterwards, so nothing is missed; and it looks now and then.
    const bool due =
        queue.wait(std::chrono::steady_clock::now() < look_at ? look_for_end : std::chrono::milliseconds(0));
    if (!due && std::chrono::steady_clock::now() < look_at) continue;
    look_at = std::chrono::steady_clock::now() + PairWorkTable::look_every;
    while (!stops_) {
      const auto task = queue.take();
      if (!task) break;
      search(queue, replica, *task);
    }
  }
}

/// A pair whose search fails is not tried again by any helper.
void PairHelper::search(PostgresPairQueue& queue, PairReplica& replica, const PairTask& task) {
  {
    const std::lock_guard lock(mutex_);
    work_.a = task.a;
    work_.b = task.b;
  }
  Result<std::string> found;
  try {
    found = replica.find(task);
  } catch (const Cancelled&) {
    return;
  } catch (const std::exception& e) {
    found = failure(ErrorCode::internal, e.what());
  }
  if (!found && !std::exchange(said_why_, true))  // once, until a pair is searched again
    spdlog::info("sessions {} and {} are not searched for the active server: {}", task.a, task.b,
                 found.error().message);
  if (found) said_why_ = false;
  queue.answer(task, found.value_or(std::string()));
  const std::lock_guard lock(mutex_);
  work_ = {0, 0, work_.searched + (found ? 1 : 0)};
}

}  // namespace headframe
