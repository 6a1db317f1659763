#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "common/result.hpp"
#include "server/operator/operator_access.hpp"
#include "server/operator/operator_limits.hpp"
#include "server/station/station.hpp"

namespace headframe {

/// The operator's API over HTTP/1.1 (README of this room). Each connection runs on `io` on a strand of its own, so any
/// number of threads may run `io`; work that reads from the disk runs on two extra threads. Nothing that a client sends
/// ends the process. Connections, headers, bodies and waits are all limited.
///
/// The station must outlive this object. `io` must outlive the callbacks that Station::when_idle still holds.
class OperatorApi {
 public:
  OperatorApi(boost::asio::io_context& io, Station& station, const OperatorLimits& limits = {},
              const OperatorAccess& access = {});
  ~OperatorApi();  // stops
  OperatorApi(const OperatorApi&) = delete;
  OperatorApi& operator=(const OperatorApi&) = delete;

  /// Opens the port (0: any free one). Call once. `host` is an address or a name. unavailable: the port is in use, or
  /// cannot be opened; invalid_argument: the host is unknown, or not an address of this machine.
  Result<void> listen(const std::string& host, std::uint16_t port);
  /// The port on which the API listens; 0 before listen().
  std::uint16_t port() const;
  /// Closes the port and all connections, and waits for disk work that is running. May be called from any thread, any
  /// number of times. The station is not called any more once `io` has stopped too.
  void stop();

 private:
  struct Listener;
  std::shared_ptr<Listener> listener_;
};

}  // namespace headframe
