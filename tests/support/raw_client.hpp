#pragma once
// HTTP as bytes, for tests of what a well-behaved client would not send.

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <string>

namespace headframe {

/// A client that may send what it likes.
struct RawClient {
  explicit RawClient(std::uint16_t port) : socket(io) {
    socket.connect({boost::asio::ip::address_v4::loopback(), port});
    const timeval limit{10, 0};  // a server that hangs fails the test instead of stopping it
    setsockopt(socket.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  }
  void send(const std::string& text) {
    boost::system::error_code closed_early;
    boost::asio::write(socket, boost::asio::buffer(text), closed_early);
  }
  std::string rest() {
    boost::system::error_code end;
    boost::asio::read(socket, boost::asio::dynamic_buffer(received), end);
    ended_cleanly = end == boost::asio::error::eof;
    return received;
  }
  /// Of the next response; its body is left where it is.
  std::string header() {
    const std::size_t end = boost::asio::read_until(socket, boost::asio::dynamic_buffer(received), "\r\n\r\n");
    return received.substr(0, end);
  }
  /// One response with a Content-Length.
  std::string response() {
    const std::size_t head = boost::asio::read_until(socket, boost::asio::dynamic_buffer(received), "\r\n\r\n");
    const std::string key = "Content-Length: ";
    const std::size_t length = std::stoul(received.substr(received.find(key) + key.size()));
    if (received.size() < head + length)
      boost::asio::read(socket, boost::asio::dynamic_buffer(received),
                        boost::asio::transfer_exactly(head + length - received.size()));
    std::string out = received.substr(0, head + length);
    received.erase(0, head + length);
    return out;
  }

  boost::asio::io_context io;
  boost::asio::ip::tcp::socket socket;
  std::string received;
  bool ended_cleanly = false;
};

inline std::string status_of(const std::string& response) { return response.substr(0, 12); }

}  // namespace headframe
