#pragma once

#include <cstddef>
#include <vector>

#include "client/uplink/pacing.hpp"
#include "common/endpoint.hpp"

namespace headframe {

/// The servers of one base station, of which one serves at a time: whose turn it is, and after which pause. Pure. Not
/// thread safe.
class ServerList {
 public:
  /// At least one, in the order in which they are tried.
  ServerList(std::vector<Endpoint> servers, const Backoff& backoff) : servers_(std::move(servers)), backoff_(backoff) {}

  const Endpoint& at(std::size_t server) const { return servers_.at(server); }

  /// Whom the next connection is made to; the one after that goes to the next in the list.
  std::size_t take();

  /// This one has let the robot in: should its link fall silent, it is asked first.
  void found(std::size_t server);

  /// The link to this one was lost, or an attempt came to nothing. How long to wait before the next attempt, in
  /// seconds: not at all until each has failed, then the backoff's pause, and so on.
  double failed(std::size_t server);

 private:
  std::size_t after(std::size_t server) const { return (server + 1) % servers_.size(); }

  std::vector<Endpoint> servers_;
  Backoff backoff_;
  std::size_t next_ = 0;
  std::size_t failures_ = 0;  // since one was found, or since the last pause
};

}  // namespace headframe
