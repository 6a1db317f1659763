#include "tests/conformance/peer.hpp"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <openssl/err.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "common/endpoint.hpp"

namespace headframe::conformance {
namespace {

timeval to_timeval(Clock::duration d) {
  const auto us = std::max<long>(1000, std::chrono::duration_cast<std::chrono::microseconds>(d).count());
  return {us / 1'000'000, us % 1'000'000};
}

std::string tls_words() {
  const char* reason = ERR_reason_error_string(ERR_get_error());
  return reason != nullptr ? reason : "the connection was closed";
}

}  // namespace

Peer::Peer(int socket, boost::asio::ssl::context& tls)
    : socket_(socket), ssl_(SSL_new(tls.native_handle()), &SSL_free) {
  const int yes = 1;
  ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  SSL_set_fd(ssl_.get(), socket_);
}

Peer::~Peer() { ::close(socket_); }

void Peer::wait_at_most(Clock::duration left) const {
  const timeval most = to_timeval(left);
  ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &most, sizeof most);
  ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &most, sizeof most);
}

bool Peer::handshake(Clock::time_point until) {
  wait_at_most(until - Clock::now());
  ERR_clear_error();
  if (SSL_accept(ssl_.get()) == 1) return true;
  trouble_ = Trouble::no_tls;
  words_ = tls_words();
  return false;
}

std::optional<v1::RobotMessage> Peer::read(Clock::time_point until) {
  std::array<char, 16384> bytes{};
  while (true) {
    const auto payload = frames_.next();
    if (!payload) {
      trouble_ = Trouble::bad_frame;
      words_ = payload.error().message;
      return std::nullopt;
    }
    if (*payload) {
      v1::RobotMessage message;
      if (message.ParseFromString(**payload)) return message;
      trouble_ = Trouble::no_message;
      return std::nullopt;
    }
    const auto left = until - Clock::now();
    trouble_ = Trouble::silent;
    if (left <= Clock::duration::zero()) return std::nullopt;
    wait_at_most(left);
    ERR_clear_error();
    const int n = SSL_read(ssl_.get(), bytes.data(), static_cast<int>(bytes.size()));
    if (n > 0) {
      frames_.feed({bytes.data(), static_cast<std::size_t>(n)});
      continue;
    }
    const int why = SSL_get_error(ssl_.get(), n);
    if (why == SSL_ERROR_WANT_READ || why == SSL_ERROR_WANT_WRITE) continue;  // the deadline decides
    trouble_ = Trouble::closed;
    words_ = "the client closed the connection";
    return std::nullopt;
  }
}

bool Peer::send(const v1::ServerMessage& message, bool in_pieces) {
  std::string frame;
  if (!append_frame(frame, message.SerializeAsString())) return false;
  if (!in_pieces) return send_bytes(frame);
  return std::all_of(frame.begin(), frame.end(), [&](char byte) { return send_bytes({byte}); });
}

bool Peer::send_bytes(const std::string& bytes) {
  wait_at_most(std::chrono::seconds(10));
  ERR_clear_error();
  return SSL_write(ssl_.get(), bytes.data(), static_cast<int>(bytes.size())) == static_cast<int>(bytes.size());
}

void Peer::end_sending() { ::shutdown(socket_, SHUT_WR); }

Listener::Listener(const std::string& host_port) {
  const auto wanted = parse_endpoint(host_port);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  if (!wanted || ::inet_pton(AF_INET, wanted->host.c_str(), &address.sin_addr) != 1)
    throw std::runtime_error(host_port + " is no HOST:PORT of IPv4 to listen on");
  address.sin_port = htons(wanted->port);
  socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int yes = 1;
  ::setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  socklen_t size = sizeof address;
  if (::bind(socket_, reinterpret_cast<sockaddr*>(&address), size) != 0 || ::listen(socket_, 16) != 0 ||
      ::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
    throw std::runtime_error(host_port + ": can not listen there: " + std::strerror(errno));
  address_ = wanted->host + ":" + std::to_string(ntohs(address.sin_port));
}

Listener::~Listener() { ::close(socket_); }

int Listener::accept(Clock::time_point until) const {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
  pollfd waiting{socket_, POLLIN, 0};
  if (left <= 0 || ::poll(&waiting, 1, static_cast<int>(left)) != 1) return -1;
  return ::accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC);
}

}  // namespace headframe::conformance
