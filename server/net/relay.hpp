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

/// Passes connections at one port on to another server, byte by byte: TLS goes from end to end. What a connection
/// carries begins with a header that tells who the client is (security/relay_header.hpp). Its calls belong to the
/// thread that owns it, but for connections().
class Relay {
 public:
  /// Where to, at this moment; an error: the client is turned away, and `refused` is said once in the log. Called on a
  /// thread of this; must not wait.
  using Target = std::function<Result<Endpoint>()>;

  Relay(std::string key, Target target, const RelayLimits& limits = {});
  ~Relay();  // stops; waits for the name that is being looked up, if any
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  /// Once. The endpoint it really listens on. unavailable: the port is in use, or the address is not of this machine.
  Result<Endpoint> listen(const Endpoint& at);

  /// That are passed on now. Thread safe.
  int connections() const { return count_; }

  /// The port is closed and all connections have ended when this returns; it does not wait for anybody.
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
  std::set<std::shared_ptr<RelayedConnection>> connections_;  // of the thread, and so are the next two
  std::deque<std::weak_ptr<RelayedConnection>> silent_;       // oldest first; some may have spoken since
  std::set<std::string> said_;
  std::atomic<int> count_ = 0;
  bool stopped_ = false;
  std::thread thread_;
};

}  // namespace headframe
