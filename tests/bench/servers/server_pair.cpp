#include "tests/bench/servers/server_pair.hpp"

#include <chrono>
#include <csignal>
#include <thread>

namespace headframe::bench {

using namespace std::chrono_literals;

ServerPair::ServerPair(std::filesystem::path scratch, const std::string& url)
    : scratch_(std::move(scratch)), config_("[store]\nurl = \"" + url + "\"\nstandby = true\n") {}

Result<void> ServerPair::start(std::size_t i) {
  auto served = serve(scratch_ / ("server" + std::to_string(i)), config_, at_[i]);
  if (!served) return tl::unexpected(served.error());
  at_[i] = {"127.0.0.1:" + std::to_string(served->port), served->http};
  servers_[i].emplace(std::move(*served));
  return {};
}

Result<void> ServerPair::start() {
  auto done = start(0);
  if (done) done = make_known_as(*servers_[0], scratch_ / "server1");
  if (done) done = start(1);
  return done;
}

Result<void> ServerPair::mend() {
  for (std::size_t i = 0; i < servers_.size(); ++i)
    if (!halted_[i] && servers_[i]->process.poll() >= 0)
      if (auto done = start(i); !done) return done;
  return {};
}

Result<std::size_t> ServerPair::active() {
  const auto deadline = std::chrono::steady_clock::now() + 60s;
  while (std::chrono::steady_clock::now() < deadline) {
    for (std::size_t i = 0; i < servers_.size(); ++i)
      if (!halted_[i] && servers_[i]->process.poll() < 0 && servers_[i]->is_active()) return i;
    std::this_thread::sleep_for(5ms);
  }
  return failure(ErrorCode::unavailable, "no server serves; see the logs in " + scratch_.string());
}

std::string ServerPair::robots() const { return at_[0].listen + "," + at_[1].listen; }

void ServerPair::halt(std::size_t i) {
  halted_.at(i) = true;
  servers_[i]->process.signal(SIGSTOP);
}

void ServerPair::go_on(std::size_t i) {
  halted_.at(i) = false;
  servers_[i]->process.signal(SIGCONT);
}

}  // namespace headframe::bench
