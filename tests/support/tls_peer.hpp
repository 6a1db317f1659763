#pragma once
// A robot over TLS, written byte by byte.

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/write.hpp>

#include "common/security/secret.hpp"
#include "tests/support/hostile_peers.hpp"
#include "tests/support/robot_bytes.hpp"

namespace headframe::test {

class TlsPeer {
 public:
  /// before_tls: what it sends in the clear first.
  explicit TlsPeer(const HostileTarget& target, const std::string& before_tls = "") {
    boost::system::error_code fault;
    stream_.next_layer().connect({boost::asio::ip::make_address(target.server.host), target.server.port}, fault);
    if (!fault) boost::asio::write(stream_.next_layer(), boost::asio::buffer(before_tls), fault);
    if (!fault) stream_.handshake(boost::asio::ssl::stream_base::client, fault);
  }

  void send(const std::string& bytes) {
    boost::system::error_code closed;  // until_closed() tells
    boost::asio::write(stream_, boost::asio::buffer(bytes), closed);
  }

  std::optional<v1::ServerMessage> read() {
    while (true) {
      const auto payload = frames_.next();
      v1::ServerMessage message;
      if (payload && *payload && message.ParseFromString(**payload)) return message;
      std::array<char, 4096> bytes{};
      boost::system::error_code closed;
      const auto n = stream_.read_some(boost::asio::buffer(bytes), closed);
      if (closed) return std::nullopt;
      frames_.feed({bytes.data(), n});
    }
  }

  /// All bytes until the other side ends.
  std::string rest() {
    std::string all;
    boost::system::error_code closed;
    boost::asio::read(stream_, boost::asio::dynamic_buffer(all), closed);
    return all;
  }

  /// What it is told last, in words.
  std::string until_closed() {
    std::string words;
    while (const auto message = read())
      if (message->has_error()) words = message->error().message();
    return words;
  }

  void greet(const Hello& hello) {
    send(hello_frame(hello));
    for (auto message = read(); message && !message->has_welcome();) message = read();
  }

 private:
  boost::asio::io_context io_;
  boost::asio::ssl::context context_{boost::asio::ssl::context::tls_client};
  boost::asio::ssl::stream<boost::asio::ip::tcp::socket> stream_{io_, context_};
  FrameReader frames_;
};

inline Hello hello_of(const std::string& robot, const std::string& token, const std::string& code = "") {
  Hello hello = robot_hello(robot);
  hello.token = token;
  hello.enrolment_code = code;
  return hello;
}

/// As the accomplice, in a session of its own.
inline Hello accomplice_hello(const HostileTarget& target, const std::string& session) {
  Hello hello = hello_of(target.accomplice, target.token);
  hello.session.session = session;
  return hello;
}

inline std::string new_name() { return to_hex(random_secret(8)); }

inline v1::RobotMessage pinged(std::uint64_t nonce) {
  v1::RobotMessage message;
  message.mutable_ping()->set_nonce(nonce);
  return message;
}

/// A connection of the accomplice in a session of its own.
class Accomplice {
 public:
  explicit Accomplice(const HostileTarget& target, const FamilySpec& family = robot_hello().family,
                      const std::string& session = new_name())
      : peer_(target) {
    Hello hello = accomplice_hello(target, session);
    hello.family = family;
    peer_.greet(hello);
  }
  void send(const std::string& bytes) { peer_.send(bytes); }
  /// Until all that was sent was looked at, or the server has had enough.
  void settle() {
    send(frame(pinged(7)));
    for (auto message = peer_.read(); message && message->pong().nonce() != 7;) message = peer_.read();
  }

 private:
  TlsPeer peer_;
};

inline std::string cloud_frames(std::uint64_t sequence, const std::string& encoded) {
  constexpr std::size_t most = 8192;
  std::string out;
  for (std::size_t at = 0; at < encoded.size(); at += most)
    out += chunk_frame(sequence, encoded.size(), at, encoded.substr(at, most));
  return out;
}

}  // namespace headframe::test
