#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <memory>
#include <string>

#include "common/endpoint.hpp"
#include "server/net/relay_limits.hpp"

namespace headframe {

/// A client's connection, and the connection to the server that carries its bytes. The second one is made when the
/// client sends its first bytes. Only the first byte is examined, to detect a client that another relay has passed on
/// already. There is one buffer for each direction; if a side does not read, its peer is not read from either. Not
/// thread safe: use an io_context with one thread. The object lives until both connections have ended.
class RelayedConnection : public std::enable_shared_from_this<RelayedConnection> {
 public:
  using Ended = std::function<void(bool came_back)>;

  /// `header` is sent to the server before the client's bytes.
  RelayedConnection(boost::asio::ip::tcp::socket client, std::string header, const RelayLimits& limits);

  /// Call once. `ended` is called once; came_back: another relay had passed the client on already.
  void start(const Endpoint& target, Ended ended);
  void end(bool came_back = false);
  /// Whether the client has sent something, so that the server is being connected.
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
  std::string to_send_;  // sent to the server first
  bool has_spoken_ = false;
  const RelayLimits limits_;
  Ended ended_;  // null: not started, or ended
  Way up_{client_, server_}, down_{server_, client_};
};

}  // namespace headframe
