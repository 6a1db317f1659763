#pragma once
// A PostgreSQL of the tests' own: made in a temporary folder, reached through a unix socket in it alone.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "tests/support/process.hpp"

namespace headframe::test {

/// Ended with this, and by the kernel should this process die first; its folder is then removed when the next one is
/// made. Run as root it is another user's, as PostgreSQL wants it. Not thread safe; the thread that starts it must
/// outlive it.
class PostgresCluster {
 public:
  /// Where its programs are; empty: it is not installed.
  static std::filesystem::path programs();
  static constexpr const char* not_installed =
      "PostgreSQL is not installed, so nothing is tested with it: apt-get install postgresql";

  /// Makes and starts one; ready when it returns. In a folder of its own in `place`; without one in memory, if there is
  /// enough, where commits cost nothing.
  static Result<std::unique_ptr<PostgresCluster>> make(const std::filesystem::path& place = {});
  /// One for all tests of this process, made at the first call; null: it did not start, and the test has failed.
  static PostgresCluster* of_this_process();

  ~PostgresCluster();

  /// An empty database of its own; its URL.
  Result<std::string> make_database();
  std::string url(const std::string& database) const;
  /// Its socket is in it.
  const std::filesystem::path& folder() const { return folder_; }
  /// As its superuser, in the database that every cluster has.
  Result<void> execute(const std::string& sql);

  /// SIGKILL to all of its processes.
  void kill();
  /// After kill(): it recovers, and is ready when it returns.
  Result<void> start();

 private:
  explicit PostgresCluster(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::vector<std::string> as_unprivileged(const std::string& program) const;

  const std::filesystem::path folder_;
  int lock_ = -1;  // on a file in the folder, held by this process: who finds it free may remove the folder
  std::optional<Process> server_;
  int databases_ = 0;
};

}  // namespace headframe::test
