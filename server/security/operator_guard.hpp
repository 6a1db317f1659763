#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.hpp"
#include "server/security/attempt_limiter.hpp"
#include "server/security/operator_registry.hpp"

namespace headframe {

/// The operator's token, 64 hexadecimal digits, from DIRECTORY/operator.token; made (mode 0600) when it is not there.
/// Errors are those of read_private_file, but not_found; bad_input: something else is in the file.
Result<std::string> operator_token(const std::filesystem::path& directory);

/// Lets in who shows the server's own token, or that of a named operator. Thread safe.
class OperatorGuard {
 public:
  /// An empty token lets everybody in. `people` may be null, and has to outlive this.
  explicit OperatorGuard(const std::string& token, const AttemptLimits& limits = {},
                         const OperatorRegistry* people = nullptr);

  /// limited: wrong, and one of too many from this address. The right token is welcome even then: 256 random bits are
  /// not guessed, and otherwise one forgotten browser tab would lock the operator out.
  /// expired: it was a named operator's.
  enum class Verdict { welcome, missing, wrong, limited, expired };
  /// `authorization` is the value of that header: "Bearer TOKEN". `who` gets who is welcome, if it is not null;
  /// `unix_s` is the time that named operators' tokens are judged by.
  Verdict check(std::string_view authorization, const boost::asio::ip::address& from, AttemptLimiter::Time now,
                double unix_s = 0, OperatorIdentity* who = nullptr);

 private:
  const std::string digest_;  // of the token; empty: there is none
  const OperatorRegistry* const people_;
  AttemptLimiter attempts_;
};

}  // namespace headframe
