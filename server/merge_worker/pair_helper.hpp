#pragma once
// A standby server's help with merging.

#include <atomic>
#include <mutex>
#include <thread>

#include "server/merge/merge_config.hpp"
#include "server/store/postgres_pair_work.hpp"

namespace headframe {

/// Searches pairs of sessions that the active server announces, one after another, on a thread of low priority. Where
/// the database is away or has an older schema it waits. Thread safe.
class PairHelper {
 public:
  struct Work {
    SessionId a = 0, b = 0;      // searched now; 0: none; a == b: how the session looks like itself
    std::uint64_t searched = 0;  // since the start
  };

  /// self: a number of this server's own.
  PairHelper(const std::string& url, const std::string& database, std::int64_t self, const MergeConfig& config);
  ~PairHelper();  // waits until the thread has ended

  /// No more is searched; what is in progress ends within a moment. Does not wait.
  void stop() { stops_ = true; }
  Work work() const;

 private:
  void run();
  void search(PostgresPairQueue& queue, class PairReplica& replica, const PairTask& task);

  const std::string url_, database_;
  const std::int64_t self_;
  const MergeConfig config_;
  std::atomic<bool> stops_ = false;
  bool said_why_ = false;  // of the thread: why a pair was not searched
  mutable std::mutex mutex_;
  Work work_;
  std::thread thread_;  // last, because it uses the members above
};

}  // namespace headframe
