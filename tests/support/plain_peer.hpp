#pragma once
// One end of a TCP connection that sends and reads bytes, and waits ten seconds at most.

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>

#include "common/endpoint.hpp"

namespace headframe {

class PlainPeer {
 public:
  using tcp = boost::asio::ip::tcp;

  /// Connects; `from`: the address of this machine that it has.
  explicit PlainPeer(const Endpoint& server, const std::string& from = "127.0.0.1") {
    socket_->open(tcp::v4());
    socket_->bind({boost::asio::ip::make_address(from), 0});
    socket_->connect({boost::asio::ip::make_address(server.host), server.port});
    be_patient();
  }
  explicit PlainPeer(tcp::acceptor& acceptor) {
    pollfd waits{acceptor.native_handle(), POLLIN, 0};
    EXPECT_EQ(::poll(&waits, 1, 10'000), 1) << "nobody came";
    acceptor.non_blocking(true);
    boost::system::error_code none;
    acceptor.accept(*socket_, none);
    be_patient();
  }

  tcp::socket& socket() { return *socket_; }

  /// False: the connection has ended.
  bool send(const std::string& bytes) {
    for (std::size_t sent = 0; sent < bytes.size();) {
      const auto n = ::send(socket_->native_handle(), bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
      if (n <= 0) return false;
      sent += static_cast<std::size_t>(n);
    }
    return true;
  }

  /// So many bytes, or what came before the end.
  std::string read(std::size_t bytes) {
    std::string all;
    std::array<char, 65536> some{};
    while (all.size() < bytes) {
      const auto n = ::recv(socket_->native_handle(), some.data(), std::min(some.size(), bytes - all.size()), 0);
      if (n <= 0) break;
      all.append(some.data(), static_cast<std::size_t>(n));
    }
    return all;
  }

  /// All that comes until the other side ends.
  std::string rest() { return read(std::string::npos); }

  /// The other side ends it, and sends nothing before.
  testing::AssertionResult is_turned_away() {
    char byte = 0;
    const auto n = ::recv(socket_->native_handle(), &byte, 1, 0);
    const int error = n < 0 ? errno : 0;
    if (n == 0 || error == ECONNRESET) return testing::AssertionSuccess();
    return testing::AssertionFailure() << (n > 0 ? "it was answered" : std::strerror(error));
  }

  /// The server may have turned it away before.
  void end_sending() {
    boost::system::error_code ignored;
    socket_->shutdown(tcp::socket::shutdown_send, ignored);
  }

 private:
  void be_patient() {
    const timeval patience{10, 0};
    ::setsockopt(socket_->native_handle(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    ::setsockopt(socket_->native_handle(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  }

  std::unique_ptr<boost::asio::io_context> io_ = std::make_unique<boost::asio::io_context>();
  std::unique_ptr<tcp::socket> socket_ = std::make_unique<tcp::socket>(*io_);
};

}  // namespace headframe
