#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <deque>
#include <functional>
#include <set>
#include <thread>

#include "server/net/relayed_connection.hpp"

namespace headframe {

/// Relays connections from one port to another server, byte by byte, so TLS is end to end. Before the client's bytes it
/// sends a header with the client's address (security/relay_header.hpp). Not thread safe, except connections().
class Relay {
 public:
  /// Returns the server to which to relay now. With an error the client is disconnected; the message of a `refused` is
  /// logged once. Called on the relay's thread; must not block.
  using Target = std::function<Result<Endpoint>()>;

  Relay(std::string key, Target target, const RelayLimits& limits = {});
  ~Relay();  // stops; waits for a name lookup in progress
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  /// Call once. Returns the endpoint with the actual port. unavailable: the port is in use, or the address is not of
  /// this machine.
  Result<Endpoint> listen(const Endpoint& at);

  /// The number of clients connected now. Thread safe.
  int connections() const { return count_; }

  /// Closes the port and all connections before it returns; does not wait for any peer.
  void stop();

 private:
  void accept();
  void welcome(boost::asio::ip::tcp::socket client);
  void make_room_for_silence();
  void say_once(const std::string& what);

  const std::string key_;
  const Target target_;
  const RelayLimits limits_;
  boost::asio::io_context io_;
  boost::asio::ip::tcp::acceptor acceptor_;
  boost::asio::steady_timer pause_;
  std::set<std::shared_ptr<RelayedConnection>> connections_;  // used only on the thread, like the next two
  std::deque<std::weak_ptr<RelayedConnection>> silent_;       // oldest first; some may have spoken since
  std::set<std::string> said_;
  std::atomic<int> count_ = 0;
  bool stopped_ = false;
  std::thread thread_;
};

}  // namespace headframe
