#pragma once

#include <cstddef>
#include <vector>

#include "client/uplink/pacing.hpp"
#include "common/endpoint.hpp"

namespace headframe {

/// The servers of one base station, of which one is active at a time: which one to try next, and after what pause.
/// Pure. Not thread safe.
class ServerList {
 public:
  /// At least one server, in the order in which they are tried.
  ServerList(std::vector<Endpoint> servers, const Backoff& backoff) : servers_(std::move(servers)), backoff_(backoff) {}

  const Endpoint& at(std::size_t server) const { return servers_.at(server); }

  /// The server for the next connection; the call after it gives the next one in the list.
  std::size_t take();

  /// This server has accepted the robot: if its connection goes silent, it is tried first.
  void found(std::size_t server);

  /// The connection to this server was lost, or an attempt failed. Returns the seconds to wait before the next attempt:
  /// 0 until each server has failed once, then the backoff's pause, and so on.
  double failed(std::size_t server);

 private:
  std::size_t after(std::size_t server) const { return (server + 1) % servers_.size(); }

  std::vector<Endpoint> servers_;
  Backoff backoff_;
  std::size_t next_ = 0;
  std::size_t failures_ = 0;  // since a server was found, or since the last pause
};

}  // namespace headframe
