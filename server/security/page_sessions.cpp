#include "server/security/page_sessions.hpp"

#include <algorithm>

#include "common/security/secret.hpp"

namespace headframe {

std::string PageSessions::begin(std::string credentials, Time now) {
  std::string secret = to_hex(random_secret(token_bytes));
  const std::lock_guard lock(mutex_);
  if (sessions_.size() >= most)
    sessions_.erase(std::min_element(sessions_.begin(), sessions_.end(),
                                     [](const auto& a, const auto& b) { return a.second.used < b.second.used; }));
  sessions_[sha256(secret)] = {std::move(credentials), now};
  return secret;
}

std::optional<std::string> PageSessions::credentials(std::string_view secret, Time now) {
  const std::lock_guard lock(mutex_);
  std::erase_if(sessions_, [&](const auto& entry) { return now - entry.second.used >= unused; });
  const auto found = sessions_.find(sha256(secret));
  if (found == sessions_.end()) return std::nullopt;
  found->second.used = now;
  return found->second.credentials;
}

void PageSessions::end(std::string_view secret) {
  const std::lock_guard lock(mutex_);
  sessions_.erase(sha256(secret));
}

}  // namespace headframe
