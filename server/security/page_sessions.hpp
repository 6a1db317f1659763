#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace headframe {

/// Lets a browser show its token only once: afterwards it shows a secret that is valid for one page session. Kept in
/// memory only, so after a restart pages ask for the token again. Thread safe.
class PageSessions {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::size_t most = 256;         // beyond, the one unused for longest ends
  static constexpr std::chrono::hours unused{12};  // after which a session ends

  /// Starts a session and returns its secret, 64 hexadecimal digits. `credentials` are kept as shown; OperatorGuard
  /// checks each time whether they are still valid.
  std::string begin(std::string credentials, Time now);
  /// The credentials shown at the start; nullopt: there is no session with this secret.
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
