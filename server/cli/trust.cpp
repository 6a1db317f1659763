#include "server/cli/trust.hpp"

#include "common/security/private_file.hpp"
#include "common/security/secret.hpp"
#include "common/security/tls.hpp"

namespace headframe {
namespace {

constexpr std::size_t fingerprint_bytes = 32;

}  // namespace

Result<WebTrust> find_trust(std::string fingerprint, const std::string& authorities, const std::string& token_file) {
  if (!fingerprint.empty() && !authorities.empty())
    return failure(ErrorCode::invalid_argument, "--fingerprint and --ca are two ways to know the server: give one");
  if (!authorities.empty()) return WebTrust{.authorities = authorities};
  if (!fingerprint.empty()) {
    std::erase(fingerprint, ':');
    for (char& digit : fingerprint) digit = digit >= 'A' && digit <= 'F' ? static_cast<char>(digit - 'A' + 'a') : digit;
    const auto bytes = from_hex(fingerprint, fingerprint_bytes);
    if (bytes) return WebTrust{.fingerprint = *bytes};
    return failure(ErrorCode::invalid_argument,
                   "--fingerprint: it has 64 hexadecimal digits, as headframe-server prints them at its start");
  }
  const std::filesystem::path token = token_file.empty() ? "headframe-data/operator.token" : token_file;
  const auto identity = read_private_file(token.parent_path() / "identity.pem");
  const auto own = identity ? fingerprint_of(*identity) : Result<std::string>(std::string());
  return WebTrust{.fingerprint = own.value_or(""), .fingerprint_only = false};
}

}  // namespace headframe
