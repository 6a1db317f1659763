#pragma once
// The protocol on a socket: one strand, one read and one write at a time.

#include <array>
#include <atomic>
#include <boost/asio/steady_timer.hpp>
#include <memory>

#include "common/security/link_stream.hpp"
#include "server/net/robot_protocol.hpp"
#include "server/net/session_hub.hpp"
#include "server/security/robot_gate.hpp"

namespace headframe {

/// How robots come in. tls and gate both, or none: without them anyone may be any robot, in the clear (--insecure).
struct Entrance {
  boost::asio::ssl::context* tls = nullptr;
  RobotGate* gate = nullptr;
  std::string relay_key = {};  // of the servers that pass robots on; empty: nobody may say for whom he speaks
};

/// The RobotLink calls come from any thread; all else runs on the socket's strand. Backpressure: while more than
/// limits.undurable_mib of this robot's bytes wait for the disk its socket is not read, so TCP holds the robot back and
/// nobody else. Lives as long as its socket is open.
class RobotConnection : public RobotLink, public std::enable_shared_from_this<RobotConnection> {
 public:
  /// The socket's executor must be a strand.
  RobotConnection(boost::asio::ip::tcp::socket socket, SessionHub& hub, const Entrance& entrance,
                  const RobotLimits& limits);

  void start();
  /// Whether the robot was let in. Thread safe.
  bool admitted() const { return admitted_; }
  /// The server stops. Thread safe.
  void shut();

  void settled(std::size_t bytes, const Result<void>& result) override;
  void keyframes_durable(std::uint64_t sequence) override;
  void poses_durable(std::uint64_t update) override;
  void cloud_durable(std::uint64_t sequence) override;
  void cloud_refused(std::uint64_t sequence, const std::string& reason) override;
  void request_submap(const std::vector<std::uint64_t>& sequences) override;
  void update_transform(std::shared_ptr<const TransformPages> pages) override;
  void tell_localization(std::shared_ptr<const std::string> payload) override;
  void tell_surroundings(SurroundingsKind kind, std::shared_ptr<const std::string> payload) override;
  void stand_by() override;
  void close(v1::ErrorKind kind, const std::string& message, bool permanent) override;

 private:
  using Clock = std::chrono::steady_clock;

  template <class Action>
  void on_strand(Action action);
  void meet();
  void meet_relay();
  void shake_hands();
  void begin();
  void read();
  void on_bytes(std::size_t bytes);
  void take_events();
  void take(RobotEvent event);
  void check(CloudArrived cloud);
  void greet(const Hello& hello);
  void admit(const Hello& hello);
  void refuse(const Error& error);
  void not_stored(const Error& error);
  void note(const std::string& what) const;
  void flush();
  void after_last_word();
  void tick();
  void tell_policy();
  void drop();
  bool crowded() const;

  LinkStream stream_;
  boost::asio::ip::address from_;
  boost::asio::steady_timer timer_;
  SessionHub& hub_;
  const Entrance entrance_;
  const RobotLimits limits_;
  RobotProtocol protocol_;
  SessionId session_ = 0;  // 0: not admitted
  std::size_t undurable_bytes_ = 0;
  std::atomic<bool> admitted_ = false;
  bool relayed_ = false;    // by a server that stands by
  bool begun_ = false;      // the handshake is over, or there is none
  bool deciding_ = false;   // whether to let it in: nothing is read meanwhile
  LinkPolicy told_;         // as the robot knows it
  bool checking_ = false;   // whether a cloud of it decodes: nothing else of it is looked at meanwhile
  bool held_back_ = false;  // its socket is not read: crowded()
  bool reading_ = false, writing_ = false, finishing_ = false, dropped_ = false;
  Clock::time_point write_began_, finish_began_;
  std::string output_;
  std::array<char, 16 * 1024> input_;  // a TLS record at a time
  std::size_t drained_bytes_ = 0;      // since its last word
};

}  // namespace headframe
