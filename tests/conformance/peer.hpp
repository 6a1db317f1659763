#pragma once
// The base station's end of one connection, blocking with deadlines.

#include <openssl/ssl.h>

#include <boost/asio/ssl/context.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "common/wire/frame_codec.hpp"
#include "headframe/v1/robot.pb.h"

namespace headframe::conformance {

using Clock = std::chrono::steady_clock;

/// Not thread safe. Closes the connection at its end.
class Peer {
 public:
  enum class Trouble { none, silent, closed, bad_frame, no_message, no_tls };

  Peer(int socket, boost::asio::ssl::context& tls);
  ~Peer();
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  /// False: the client gave up or speaks no TLS 1.3; words() says what was seen.
  bool handshake(Clock::time_point until);

  /// The next message; nullopt: trouble() says why. no_message stays readable: the frame was passed over.
  std::optional<v1::RobotMessage> read(Clock::time_point until);
  Trouble trouble() const { return trouble_; }
  const std::string& words() const { return words_; }

  /// False: the client has gone. in_pieces: every byte by itself, so that a reader that counts on whole frames shows.
  bool send(const v1::ServerMessage& message, bool in_pieces = false);
  bool send_bytes(const std::string& bytes);

  /// No more is sent; what the client still says can be read.
  void end_sending();

 private:
  void wait_at_most(Clock::duration left) const;

  int socket_;
  std::unique_ptr<SSL, void (*)(SSL*)> ssl_;
  FrameReader frames_;
  Trouble trouble_ = Trouble::none;
  std::string words_;
};

/// Listens on a loopback port of its own choice, or the one given.
class Listener {
 public:
  /// Throws std::runtime_error when it can not listen there.
  explicit Listener(const std::string& host_port);
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  const std::string& address() const { return address_; }

  /// -1: nobody came in time.
  int accept(Clock::time_point until) const;

 private:
  int socket_ = -1;
  std::string address_;
};

}  // namespace headframe::conformance
