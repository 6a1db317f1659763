#include "tests/bench/servers/probe.hpp"

#include <chrono>

#include "tests/bench/link/drive.hpp"
#include "tests/bench/link/seconds_since.hpp"

namespace headframe::bench {

using namespace std::chrono_literals;

Result<std::unique_ptr<Probe>> Probe::start(const std::filesystem::path& spool, const std::string& servers,
                                            const std::string& enrolment) {
  const auto peers = parse_peers(servers);
  if (!peers) return tl::unexpected(peers.error());
  auto config = drive_config(name, spool, peers->front().host, peers->front().port, enrolment);
  config.more_servers.assign(peers->begin() + 1, peers->end());
  auto client = RobotClient::open(config);
  if (!client) return tl::unexpected(client.error());
  return std::unique_ptr<Probe>(new Probe(std::move(*client)));
}

Probe::Probe(std::unique_ptr<RobotClient> client) : client_(std::move(client)) {
  drives_ = std::jthread([this](const std::stop_token& stop) {
    for (auto due = Clock::now(); !stop.stop_requested(); std::this_thread::sleep_until(due += 50ms))
      if (const auto added = add_drive_keyframe(*client_, name, added_ + 1); added && *added) ++added_;
  });
}

Probe::~Probe() { drives_.request_stop(); }

Result<double> Probe::acknowledged_after(Clock::time_point begin) const {
  const std::uint64_t before = added_;
  while (since(begin) < 60) {
    if (client_->progress().keyframes_acknowledged > before) return since(begin);
    std::this_thread::sleep_for(2ms);
  }
  return failure(ErrorCode::unavailable, "a robot was not acknowledged again: " + client_->progress().link_error);
}

Result<std::uint64_t> Probe::finish() {
  drives_.request_stop();
  drives_.join();
  const auto done = client_->finish(60s);
  if (!done) return tl::unexpected(done.error());
  return added_.load();
}

}  // namespace headframe::bench
