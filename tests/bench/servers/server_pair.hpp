#pragma once

#include <array>
#include <filesystem>
#include <optional>

#include "tests/bench/link/served.hpp"

namespace headframe::bench {

/// Two servers on one PostgreSQL, kept as a service manager would keep them: what has ended is started again at its old
/// address, and waits. Not thread safe.
class ServerPair {
 public:
  ServerPair(std::filesystem::path scratch, const std::string& url);

  /// One serves and the other stands by.
  Result<void> start();

  /// Starts what has ended, and waits until it stands by or serves. Fails when a server does not come back.
  Result<void> mend();

  /// The one that serves; a server that is halted counts for nothing. Waits for it. unavailable: none in 60 s.
  Result<std::size_t> active();

  Served& server(std::size_t i) { return *servers_.at(i); }
  const std::filesystem::path& data() const { return servers_[0]->data; }
  std::string robots() const;  // HOST:PORT,HOST:PORT
  const std::string& http(std::size_t i) const { return at_.at(i).http; }

  void halt(std::size_t i);  // SIGSTOP; nothing of it is looked at until
  void go_on(std::size_t i);

 private:
  Result<void> start(std::size_t i);

  const std::filesystem::path scratch_;
  const std::string config_;
  std::array<ServedAt, 2> at_;
  std::array<std::optional<Served>, 2> servers_;
  std::array<bool, 2> halted_{};
};

}  // namespace headframe::bench
