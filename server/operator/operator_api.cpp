#include "server/operator/operator_api.hpp"

#include <algorithm>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <vector>

#include "server/operator/http_session.hpp"

namespace headframe {

namespace net = boost::asio;
using boost::system::error_code;
using net::ip::tcp;

void HttpShared::accept(tcp::socket socket) {
  std::shared_ptr<HttpSession> session;
  {
    const std::lock_guard lock(mutex_);
    if (stopped_) return;
    const bool full = !make_room();
    const auto turned_away = static_cast<std::size_t>(
        std::count_if(sessions_.begin(), sessions_.end(), [](const auto& s) { return s.second.turned_away; }));
    if (full && turned_away >= limits.connections) return;
    session = std::make_shared<HttpSession>(std::move(socket), shared_from_this(), full);
    sessions_[session] = {.since = ++events_seen_, .turned_away = full};
  }
  session->start();
}

/// Makes room for one more connection, by closing another if necessary; false: none may be closed. Call with the lock
/// held.
bool HttpShared::make_room() {
  std::size_t served = 0;
  auto oldest = sessions_.end();
  for (auto it = sessions_.begin(); it != sessions_.end(); ++it) {
    const Seat& seat = it->second;
    if (seat.turned_away) continue;
    ++served;
    // If a token is required, a client without it gets only public targets; such a response may be cut off too.
    const bool may_go = !seat.has_token && (seat.waits || asks_token);
    const auto rank = [](const Seat& s) { return std::pair(!s.waits, s.since); };
    if (may_go && (oldest == sessions_.end() || rank(seat) < rank(oldest->second))) oldest = it;
  }
  if (served < limits.connections) return true;
  if (oldest == sessions_.end()) return false;
  oldest->first->close();
  sessions_.erase(oldest);
  return true;
}

void HttpShared::note(const std::shared_ptr<HttpSession>& session, bool waits, bool has_token) {
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(session);
  if (found == sessions_.end()) return;
  found->second.since = ++events_seen_;
  found->second.waits = waits;
  found->second.has_token |= has_token;
}

void HttpShared::forget(const std::shared_ptr<HttpSession>& session) {
  const std::lock_guard lock(mutex_);
  sessions_.erase(session);
}

void HttpShared::stop() {
  std::map<std::shared_ptr<HttpSession>, Seat> sessions;
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    sessions.swap(sessions_);
  }
  for (const auto& [session, seat] : sessions) session->close();
  events->stop();
  disk.stop();
  disk.join();
}

struct OperatorApi::Listener : std::enable_shared_from_this<Listener> {
  Listener(net::io_context& the_io, Station& station, const OperatorLimits& limits, const OperatorAccess& access)
      : io(the_io),
        acceptor(net::make_strand(the_io)),
        pause(acceptor.get_executor()),
        shared(std::make_shared<HttpShared>(the_io, station, limits, access)) {}

  Result<void> open(const std::string& host, std::uint16_t port);
  void accept();

  net::io_context& io;
  tcp::acceptor acceptor;
  net::steady_timer pause;
  std::shared_ptr<HttpShared> shared;
  std::uint16_t bound_port = 0;
};

Result<void> OperatorApi::Listener::open(const std::string& host, std::uint16_t port) {
  const std::string where = host + ":" + std::to_string(port);
  error_code code;
  const auto found = tcp::resolver(io).resolve(host, std::to_string(port), tcp::resolver::passive, code);
  if (code || host.empty() || found.empty())
    return failure(ErrorCode::invalid_argument, "HTTP: \"" + host + "\" is no host name" +
                                                    (code ? " (" + code.message() + ")" : "") +
                                                    "; give an address of this machine");
  const tcp::endpoint endpoint = *found.begin();
  acceptor.open(endpoint.protocol(), code);
  if (!code) acceptor.set_option(tcp::acceptor::reuse_address(true), code);
  if (!code) acceptor.bind(endpoint, code);
  if (!code) acceptor.listen(tcp::acceptor::max_listen_connections, code);
  if (!code) {
    bound_port = acceptor.local_endpoint().port();
    return {};
  }
  error_code ignored;
  acceptor.close(ignored);
  if (code == net::error::address_in_use)
    return failure(ErrorCode::unavailable,
                   "HTTP: " + where + " is in use; is a server running already? Choose another port");
  const bool foreign = code == boost::system::errc::address_not_available;
  return failure(
      foreign ? ErrorCode::invalid_argument : ErrorCode::unavailable,
      "HTTP: cannot listen on " + where + ": " + code.message() + (foreign ? "; give an address of this machine" : ""));
}

void OperatorApi::Listener::accept() {
  acceptor.async_accept(net::make_strand(io), [self = shared_from_this()](error_code code, tcp::socket socket) {
    if (!self->acceptor.is_open()) return;
    if (!code) {
      self->shared->accept(std::move(socket));
      return self->accept();
    }
    self->pause.expires_after(std::chrono::milliseconds(100));  // out of file descriptors: do not spin
    self->pause.async_wait([self](error_code ended) {
      if (!ended && self->acceptor.is_open()) self->accept();
    });
  });
}

OperatorApi::OperatorApi(net::io_context& io, Station& station, const OperatorLimits& limits,
                         const OperatorAccess& access)
    : listener_(std::make_shared<Listener>(io, station, limits, access)) {}

OperatorApi::~OperatorApi() { stop(); }

Result<void> OperatorApi::listen(const std::string& host, std::uint16_t port) {
  auto opened = listener_->open(host, port);
  listener_->shared->serve_under(host);
  if (opened) listener_->shared->events->start();
  if (opened) net::post(listener_->acceptor.get_executor(), [listener = listener_] { listener->accept(); });
  return opened;
}

std::uint16_t OperatorApi::port() const { return listener_->bound_port; }

void OperatorApi::stop() {
  net::post(listener_->acceptor.get_executor(), [listener = listener_] {
    error_code ignored;
    listener->acceptor.close(ignored);
    listener->pause.cancel();
  });
  listener_->shared->stop();
}

}  // namespace headframe
