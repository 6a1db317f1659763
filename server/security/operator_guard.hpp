#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.hpp"
#include "server/security/attempt_limiter.hpp"
#include "server/security/operator_registry.hpp"

namespace headframe {

/// The operator's token, 64 hexadecimal digits, from DIRECTORY/operator.token, which is created (mode 0600) if it does
/// not exist. Fails like read_private_file, except not_found; bad_input: the file has other content.
Result<std::string> operator_token(const std::filesystem::path& directory);

/// Accepts the server's own token or that of a named operator. Thread safe.
class OperatorGuard {
 public:
  /// An empty token accepts everybody. `people` may be null, and must outlive this object.
  explicit OperatorGuard(const std::string& token, const AttemptLimits& limits = {},
                         const OperatorRegistry* people = nullptr);

  /// limited: wrong, after too many failures from this address. The right token is always accepted: 256 random bits
  /// cannot be guessed, and otherwise one forgotten browser tab could lock the operator out. expired: the token of a
  /// named operator, after its time.
  enum class Verdict { welcome, missing, wrong, limited, expired };
  /// `authorization` is the value of the header: "Bearer TOKEN". If not null, `who` gets the identity that was
  /// accepted; `unix_s` is the time for judging whether named operators' tokens have expired.
  Verdict check(std::string_view authorization, const boost::asio::ip::address& from, AttemptLimiter::Time now,
                double unix_s = 0, OperatorIdentity* who = nullptr);

 private:
  const std::string digest_;  // of the token; empty: no token is required
  const OperatorRegistry* const people_;
  AttemptLimiter attempts_;
};

}  // namespace headframe
