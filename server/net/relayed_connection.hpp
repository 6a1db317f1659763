#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <memory>
#include <string>

#include "common/endpoint.hpp"
#include "server/net/relay_limits.hpp"

namespace headframe {

/// One client's connection and the one that carries its bytes on, which is made when the client begins to speak. Of
/// what is said the first byte alone is looked at: whether a relay has passed the client on already. Each way has one
/// buffer: who does not read stops who writes. Not thread safe: for an io_context with one thread. Lives until both
/// have ended.
class RelayedConnection : public std::enable_shared_from_this<RelayedConnection> {
 public:
  using Ended = std::function<void(bool came_back)>;

  /// `header` goes before the client's bytes.
  RelayedConnection(boost::asio::ip::tcp::socket client, std::string header, const RelayLimits& limits);

  /// Once. `ended` is called once, with whether a relay had passed the client on already.
  void start(const Endpoint& target, Ended ended);
  void end(bool came_back = false);
  /// The client has said something, and the server is on its way.
  bool has_spoken() const { return has_spoken_; }

 private:
  using Socket = boost::asio::ip::tcp::socket;
  struct Way {
    Socket& from;
    Socket& to;
    std::string bytes = {};
    bool ended = false;
  };

  void reach(const Endpoint& target);
  void connect(const boost::asio::ip::tcp::resolver::results_type& found);
  void begin();
  void pass(Way& way);
  void pass_on_end(Way& way);
  void end_after(std::chrono::seconds time);

  Socket client_, server_;
  boost::asio::ip::tcp::resolver resolver_;
  boost::asio::steady_timer timer_;
  std::string to_send_;  // before what is passed on
  bool has_spoken_ = false;
  const RelayLimits limits_;
  Ended ended_;  // null: it has not begun, or has ended
  Way up_{client_, server_}, down_{server_, client_};
};

}  // namespace headframe
