#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace headframe {

/// What a browser shows instead of a token that it has shown once: a secret of its own, good for one page session. In
/// memory alone: after a restart pages ask for the token again. Thread safe.
class PageSessions {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::size_t most = 256;         // one more, and the one that was used longest ago ends
  static constexpr std::chrono::hours unused{12};  // after so long it ends by itself

  /// A new session's secret, 64 hexadecimal digits. `credentials` are kept as they were shown: whether they are still
  /// good is asked each time (OperatorGuard).
  std::string begin(std::string credentials, Time now);
  /// What was shown when the session began; nullopt: there is none of this secret.
  std::optional<std::string> credentials(std::string_view secret, Time now);
  void end(std::string_view secret);

 private:
  struct Session {
    std::string credentials;
    Time used;
  };
  std::mutex mutex_;
  std::map<std::string, Session> sessions_;  // by the digest of the secret
};

}  // namespace headframe
