#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.hpp"
#include "server/security/attempt_limiter.hpp"

namespace headframe {

/// The operator's token, 64 hexadecimal digits, from DIRECTORY/operator.token; made (mode 0600) when it is not there.
/// Errors are those of read_private_file, but not_found; bad_input: something else is in the file.
Result<std::string> operator_token(const std::filesystem::path& directory);

/// Lets in who shows the operator's token. Thread safe.
class OperatorGuard {
 public:
  /// An empty token lets everybody in.
  explicit OperatorGuard(const std::string& token, const AttemptLimits& limits = {});

  /// limited: wrong, and one of too many from this address. The right token is welcome even then: 256 random bits are
  /// not guessed, and otherwise one forgotten browser tab would lock the operator out.
  enum class Verdict { welcome, missing, wrong, limited };
  /// `authorization` is the value of that header: "Bearer TOKEN".
  Verdict check(std::string_view authorization, const boost::asio::ip::address& from, AttemptLimiter::Time now);

 private:
  const std::string digest_;  // of the token; empty: there is none
  AttemptLimiter attempts_;
};

}  // namespace headframe
