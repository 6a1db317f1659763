#pragma once

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <stdexcept>
#include <thread>

#include "server/operator/operator_api.hpp"
#include "tests/support/fake_station.hpp"

namespace headframe {

/// A fake station served on a free port of the loopback, on two I/O threads.
struct OperatorServer {
  explicit OperatorServer(const OperatorLimits& limits = {}, const OperatorAccess& access = {})
      : api(io, station, limits, access) {
    if (const auto open = api.listen("127.0.0.1", 0); !open) throw std::runtime_error(open.error().message);
    for (auto& thread : threads) thread = std::jthread([this] { io.run(); });
  }
  ~OperatorServer() {
    api.stop();
    work.reset();
    for (auto& thread : threads) thread.join();
  }
  std::string where() const { return "127.0.0.1:" + std::to_string(api.port()); }

  boost::asio::io_context io;
  FakeStation station;  // gone before io: its callbacks need it
  OperatorApi api;
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work = boost::asio::make_work_guard(io);
  std::array<std::jthread, 2> threads;
};

}  // namespace headframe
