#pragma once
// One client with a station of its own: started, met at each of its connections, and ended.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "tests/conformance/conversation.hpp"
#include "tests/conformance/trial.hpp"

namespace headframe::conformance {

inline constexpr auto absence = std::chrono::milliseconds(300);  // what is not to come has not come by then

class Trial {
 public:
  Trial(const std::string& name, const Course& course, const TrialConfig& config, Findings& findings);

  /// pinned: the fingerprint that the client is told, 32 bytes; empty: the right one.
  Result<void> start(const std::string& pinned = "");

  Findings& findings() { return findings_; }
  Judge& judge() { return judge_; }
  const std::string& robot() const { return robot_; }
  Clock::duration patience() const { return patience_; }
  /// The end of what the client printed.
  std::string said() const;

  /// The client's next connection, its handshake not yet done; null: it did not come, which is reported.
  std::unique_ptr<Peer> next(const std::string& awaited);
  /// The connection's hello, heard; null: there was none, which is reported.
  std::unique_ptr<Conversation> talk(Peer& peer);
  /// Nobody comes back after this, whatever time it is given.
  void expect_the_end(const std::string& after);

 private:
  std::unique_ptr<Peer> within(Clock::duration most);
  std::filesystem::path log() const { return folder_ / "client.log"; }

  const std::string robot_ = "conformance-robot";
  const std::filesystem::path folder_;
  const TrialConfig& config_;
  Findings& findings_;
  const Clock::duration patience_;
  Listener listener_;
  const std::string pem_;
  boost::asio::ssl::context tls_;
  const std::string code_;
  Judge judge_;
  Station station_;
  bool started_ = false;  // it was there once
  std::optional<test::Process> client_;
};

}  // namespace headframe::conformance
