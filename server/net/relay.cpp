#include "server/net/relay.hpp"

#include <spdlog/spdlog.h>

#include <boost/asio/post.hpp>
#include <future>
#include <utility>

#include "server/net/bind_port.hpp"
#include "server/security/relay_header.hpp"

namespace headframe {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

constexpr auto breath = std::chrono::milliseconds(100);  // after a failed accept: no file descriptors, most likely
constexpr std::size_t most_said = 16;                    // lines, however often the other servers move

}  // namespace

Relay::Relay(std::string key, Target target, const RelayLimits& limits)
    : key_(std::move(key)), target_(std::move(target)), limits_(limits), io_(1), acceptor_(io_), pause_(io_) {}

Relay::~Relay() {
  stop();
  if (thread_.joinable()) thread_.join();
}

Result<Endpoint> Relay::listen(const Endpoint& at) {
  error_code error = bind_port(acceptor_, at);
  if (!error) acceptor_.listen(boost::asio::socket_base::max_listen_connections, error);
  if (error) return listen_failure(at, error);
  const Endpoint real{at.host, acceptor_.local_endpoint().port()};
  accept();
  thread_ = std::thread([this] { io_.run(); });
  return real;
}

void Relay::accept() {
  acceptor_.async_accept([this](error_code error, tcp::socket client) {
    if (!acceptor_.is_open()) return;
    if (!error) {
      welcome(std::move(client));
      return accept();
    }
    spdlog::warn("a connection could not be accepted: {}", error.message());
    pause_.expires_after(breath);
    pause_.async_wait([this](error_code cancelled) {
      if (!cancelled) accept();
    });
  });
}

void Relay::welcome(tcp::socket client) {
  if (connections_.size() >= limits_.connections) return;
  const auto target = target_();
  if (!target && target.error().code == ErrorCode::refused) say_once(target.error().message);
  if (!target) return;
  error_code gone;
  const auto from = client.remote_endpoint(gone), here = client.local_endpoint(gone);
  if (gone) return;
  auto header = relay_header(from, here, key_);
  make_room_for_silence();
  const auto connection = std::make_shared<RelayedConnection>(std::move(client), std::move(header), limits_);
  connections_.insert(connection);
  silent_.push_back(connection);
  count_ = static_cast<int>(connections_.size());
  connection->start(*target, [this, known = std::weak_ptr(connection)](bool came_back) {
    connections_.erase(known.lock());
    count_ = static_cast<int>(connections_.size());
    if (came_back) say_once("one that another server has passed on is not passed on again");
  });
}

/// Who only holds connections can not keep others out.
void Relay::make_room_for_silence() {
  std::erase_if(silent_, [](const auto& known) {
    const auto connection = known.lock();
    return !connection || connection->has_spoken();
  });
  if (silent_.size() < limits_.silent) return;
  if (const auto oldest = silent_.front().lock()) oldest->end();
  silent_.pop_front();
}

void Relay::say_once(const std::string& what) {
  if (said_.size() < most_said && said_.insert(what).second) spdlog::warn("connections are turned away: {}", what);
}

void Relay::stop() {
  if (!thread_.joinable() || std::exchange(stopped_, true)) return;
  std::promise<void> stopped;
  boost::asio::post(io_, [&] {
    error_code ignored;
    acceptor_.close(ignored);
    pause_.cancel();
    while (!connections_.empty()) (*connections_.begin())->end();
    stopped.set_value();
  });
  stopped.get_future().wait();
}

}  // namespace headframe
