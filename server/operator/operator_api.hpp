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

/// The operator's API over HTTP/1.1 (README of this room). Connections live on `io`, each on its own strand, so any
/// number of threads may run it; what reads from disk runs on two threads of its own. Nothing a client sends ends the
/// process, and every connection, header, body and wait has a limit.
///
/// The station must outlive this object. `io` must outlive the callbacks that Station::when_idle still holds.
class OperatorApi {
 public:
  OperatorApi(boost::asio::io_context& io, Station& station, const OperatorLimits& limits = {},
              const OperatorAccess& access = {});
  ~OperatorApi();  // stops
  OperatorApi(const OperatorApi&) = delete;
  OperatorApi& operator=(const OperatorApi&) = delete;

  /// Opens the port (0: any free one); once. `host` is an address or a name. unavailable: the port is in use;
  /// invalid_argument: the host is not of this machine.
  Result<void> listen(const std::string& host, std::uint16_t port);
  /// The port that is listened on; 0 before listen().
  std::uint16_t port() const;
  /// Closes the port and all connections, and waits for the cloud that is being read, if any. From any thread, any
  /// number of times. Station is not called again once `io` has stopped too.
  void stop();

 private:
  struct Listener;
  std::shared_ptr<Listener> listener_;
};

}  // namespace headframe
