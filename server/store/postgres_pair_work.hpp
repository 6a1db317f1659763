#pragma once
// Table pair_work: pairs of sessions that the active server needs searched, and that standby servers take.

#include <chrono>
#include <functional>
#include <memory>

#include "server/session/pair_task.hpp"
#include "server/store/postgres.hpp"

namespace headframe {

/// A connection of its own for the table, made anew at the next call when it was lost, at most once a second. Nobody's
/// disk is waited for. Not thread safe.
class PairWorkTable {
 public:
  /// Who takes a pair has it so long: many times what a search takes (about a second), because a search whose lease has
  /// ended is made twice. Should it be killed, the pair waits so long, and only where nothing else is left to search.
  static constexpr double lease_s = 10;
  static constexpr auto look_every = std::chrono::milliseconds(1000);  // where no notice comes

  /// listens_to: the channel whose notices end wait().
  PairWorkTable(const std::string& url, const std::string& name, const std::string& listens_to)
      : database_(url, name), listens_to_(listens_to) {}

  /// unavailable: there is no connection.
  Result<PostgresDatabase*> connected();
  /// Whether the connection is another than at the last call.
  bool is_new() { return std::exchange(is_new_, false); }

 private:
  PostgresDatabase database_;
  const std::string listens_to_;
  std::chrono::steady_clock::time_point not_before_ = {};
  bool is_new_ = false;
};

/// The active server's side.
class PostgresPairHelpers final : public PairHelpers {
 public:
  static constexpr std::size_t most_rows = 256;

  /// any: whether there are standby servers; is called often.
  PostgresPairHelpers(const std::string& url, const std::string& name, std::function<bool()> any)
      : table_(url, name, "headframe_pair_found"), any_(std::move(any)) {}

  bool any() override { return any_(); }
  void announce(const std::vector<PairTask>& tasks) override;
  Answer ask(const PairTask& task) override;
  std::optional<PairTask> claim() override;
  /// Throws Cancelled when the caller's work is no longer wanted.
  Answer wait(const PairTask& task) override;
  void withdraw(const std::vector<PairTask>& tasks) override;

 private:
  PairWorkTable table_;
  const std::function<bool()> any_;
  std::int64_t round_ = 0;
};

/// A standby server's side.
class PostgresPairQueue {
 public:
  /// self: a number of this server's own.
  PostgresPairQueue(const std::string& url, const std::string& name, std::int64_t self,
                    double lease_s = PairWorkTable::lease_s)
      : table_(url, name, "headframe_pair_asked"), self_(self), lease_s_(lease_s) {}

  /// The next pair on which nobody works. Nullopt: there is none, or the database is away.
  std::optional<PairTask> take();
  /// empty: it could not be found; nobody tries again.
  void answer(const PairTask& task, const std::string& result);
  /// Until something is announced, at most this long; true: something was. Where the database is away, waits all of it.
  bool wait(std::chrono::milliseconds most);

 private:
  PairWorkTable table_;
  const std::int64_t self_;
  const double lease_s_;
};

}  // namespace headframe
