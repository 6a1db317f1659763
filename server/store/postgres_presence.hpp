#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "server/store/postgres.hpp"
#include "server/store/server_record.hpp"

namespace headframe {

/// Notes in table `servers` that this server is there, once a second and over a connection of its own, so that nothing
/// of it is in the writer's way; and looks who else is. What can not be noted (the database is away, or has an older
/// schema) is tried again. Thread safe.
class PostgresPresence {
 public:
  static constexpr double gone_after_s = 15;  // without a sign of life a server is not shown any more

  /// Begins with start(). `taken_over` is called once, on a thread of this, when the server was active and finds that
  /// another is; `work` once a second, on that thread: what this server does for the active one.
  PostgresPresence(const std::string& url, const std::string& database, std::function<void(const Error&)> taken_over,
                   std::function<StandbyWork()> work = {});
  ~PostgresPresence();  // the others see at once that it has gone

  /// What it tells from now on.
  void start(const ServerCard& card);
  /// The writer has put its mark into the database.
  void become_active();

  /// As of the last look; this server first where nothing could be looked at yet, then the active one. Does not wait.
  std::vector<ServerRecord> servers() const;

 private:
  using Clock = std::chrono::steady_clock;

  void run();
  void beat();
  Result<void> note(const ServerCard& card, bool active, double for_s);
  Result<void> look(const ServerCard& card, bool active);

  PostgresDatabase database_;  // of the thread
  const std::function<void(const Error&)> taken_over_;
  const std::function<StandbyWork()> work_;
  bool told_ = false;                                      // of the thread: that another has taken over
  bool counts_relayed_ = false, counts_searched_ = false;  // of the thread: the schema has columns for it
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<ServerCard> card_;
  bool active_ = false, stopping_ = false;
  Clock::time_point since_{};  // it is active, or waits
  std::vector<ServerRecord> seen_;
  Clock::time_point seen_at_{};
  std::thread thread_;
};

/// What the server tells that has the database, as far as there is one that tells anything.
std::optional<ServerCard> active_server(PostgresDatabase& database);

}  // namespace headframe
