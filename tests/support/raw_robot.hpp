#pragma once
// A robot on a real socket, written byte by byte.

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <optional>

#include "common/endpoint.hpp"
#include "tests/support/robot_bytes.hpp"

namespace headframe {

/// Waits at most ten seconds for each message.
class RawRobot {
 public:
  /// receive_bytes: what the kernel keeps for it before it reads; 0: as usual.
  explicit RawRobot(const Endpoint& server, int receive_bytes = 0) {
    socket_.open(boost::asio::ip::tcp::v4());
    if (receive_bytes > 0) socket_.set_option(boost::asio::socket_base::receive_buffer_size(receive_bytes));
    socket_.connect({boost::asio::ip::make_address(server.host), server.port});
    const timeval patience{10, 0};
    ::setsockopt(socket_.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }

  void send(const std::string& bytes) {
    boost::system::error_code ignored;  // the server may have closed: read() tells
    boost::asio::write(socket_, boost::asio::buffer(bytes), ignored);
  }

  /// nullopt: the server has closed the connection, or is silent.
  std::optional<v1::ServerMessage> read() {
    while (true) {
      const auto payload = reader_.next();
      if (payload && *payload) {
        v1::ServerMessage message;
        EXPECT_TRUE(message.ParseFromString(**payload));
        return message;
      }
      char bytes[4096];
      const auto n = ::recv(socket_.native_handle(), bytes, sizeof bytes, 0);
      if (n <= 0) return std::nullopt;
      reader_.feed({bytes, static_cast<std::size_t>(n)});
    }
  }

  /// The next message for which it holds.
  template <class Condition>
  std::optional<v1::ServerMessage> read_until(Condition condition) {
    while (auto message = read())
      if (condition(*message)) return message;
    return std::nullopt;
  }

  v1::Welcome greet(const Hello& hello) {
    send(hello_frame(hello));
    const auto message = read_until([](const auto& m) { return m.has_welcome() || m.has_error(); });
    EXPECT_TRUE(message && message->has_welcome()) << (message ? message->error().message() : "silence");
    return message ? message->welcome() : v1::Welcome();
  }

  v1::ErrorReport error() {
    const auto message = read_until([](const auto& m) { return m.has_error(); });
    EXPECT_TRUE(message);
    EXPECT_FALSE(read()) << "the connection ends with its error";
    return message ? message->error() : v1::ErrorReport();
  }

  bool acknowledged(std::uint64_t keyframe) {
    return read_until(
               [=](const auto& m) { return m.has_keyframe_ack() && m.keyframe_ack().durable_keyframes() >= keyframe; })
        .has_value();
  }

 private:
  boost::asio::io_context io_;
  boost::asio::ip::tcp::socket socket_{io_};
  FrameReader reader_;
};

}  // namespace headframe
