#include "server/net/robot_listener.hpp"

#include <spdlog/spdlog.h>

#include <boost/asio/post.hpp>
#include <boost/asio/strand.hpp>

#include "server/net/bind_port.hpp"

namespace headframe {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

constexpr auto breath = std::chrono::milliseconds(100);  // after a failed accept: no file descriptors, most likely

}  // namespace

RobotListener::RobotListener(boost::asio::io_context& io, SessionHub& hub, const Entrance& entrance,
                             const RobotLimits& limits)
    : io_(io),
      acceptor_(boost::asio::make_strand(io)),
      pause_(acceptor_.get_executor()),
      hub_(hub),
      entrance_(entrance),
      limits_(limits) {}

Result<Endpoint> RobotListener::listen(const Endpoint& at) {
  error_code error = bind_port(acceptor_, at);
  if (!error) acceptor_.listen(boost::asio::socket_base::max_listen_connections, error);
  if (error) return listen_failure(at, error);
  boost::asio::post(acceptor_.get_executor(), [this] { accept(); });
  return Endpoint{at.host, acceptor_.local_endpoint().port()};
}

void RobotListener::accept() {
  acceptor_.async_accept(boost::asio::make_strand(io_), [this](error_code error, tcp::socket socket) {
    if (!acceptor_.is_open()) return;
    if (!error) {
      welcome(std::move(socket));
      return accept();
    }
    spdlog::warn("a robot could not be accepted: {}", error.message());
    pause_.expires_after(breath);
    pause_.async_wait([this](error_code cancelled) {
      if (!cancelled) accept();
    });
  });
}

void RobotListener::welcome(tcp::socket socket) {
  const auto connection = std::make_shared<RobotConnection>(std::move(socket), hub_, entrance_, limits_);
  const std::lock_guard lock(mutex_);
  if (stopped_) return;
  std::erase_if(connections_, [](const auto& known) { return known.expired(); });
  std::shared_ptr<RobotConnection> oldest;
  int strangers = 0;
  for (const auto& known : connections_) {
    auto other = known.lock();
    if (!other || other->admitted()) continue;
    if (++strangers == 1) oldest = std::move(other);
  }
  if (strangers >= limits_.strangers) oldest->shut();
  connections_.push_back(connection);
  connection->start();
}

void RobotListener::stop() {
  boost::asio::post(acceptor_.get_executor(), [this] {
    error_code ignored;
    acceptor_.close(ignored);
    pause_.cancel();
  });
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  for (const auto& known : connections_)
    if (const auto connection = known.lock()) connection->shut();
}

}  // namespace headframe
