#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <memory>
#include <mutex>
#include <vector>

#include "common/endpoint.hpp"
#include "server/net/robot_connection.hpp"

namespace headframe {

/// Accepts robots. At most limits.strangers connections that were not let in are held: one more, and the oldest of them
/// is closed, so that who only holds connections can not keep robots out. Its calls belong to the thread that owns it;
/// it must outlive the io_context's run.
class RobotListener {
 public:
  RobotListener(boost::asio::io_context& io, SessionHub& hub, const Entrance& entrance, const RobotLimits& limits);

  /// Who has this key (relay_key) may say for which robot a connection is. Before listen(); none: nobody may.
  void believe_relays(std::string key) { entrance_.relay_key = std::move(key); }

  /// The endpoint it really listens on. unavailable: the port is in use, or the address is not of this machine.
  Result<Endpoint> listen(const Endpoint& at);
  /// Takes no more robots and ends all connections; the io_context runs out of work then.
  void stop();

 private:
  void accept();
  void welcome(boost::asio::ip::tcp::socket socket);

  boost::asio::io_context& io_;
  boost::asio::ip::tcp::acceptor acceptor_;  // on a strand
  boost::asio::steady_timer pause_;
  SessionHub& hub_;
  Entrance entrance_;
  const RobotLimits limits_;
  std::mutex mutex_;
  bool stopped_ = false;
  std::vector<std::weak_ptr<RobotConnection>> connections_;  // oldest first
};

}  // namespace headframe
