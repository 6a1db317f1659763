#include "server/security/operator_guard.hpp"

#include "common/security/private_file.hpp"
#include "common/security/secret.hpp"

namespace headframe {

Result<std::string> operator_token(const std::filesystem::path& directory) {
  const auto path = directory / "operator.token";
  auto text = read_private_file(path);
  if (!text && text.error().code == ErrorCode::not_found) {
    const std::string made = to_hex(random_secret(token_bytes));
    if (auto written = write_private_file(path, made + "\n"); !written) return tl::unexpected(written.error());
    return made;
  }
  if (!text) return text;
  while (!text->empty() && text->back() == '\n') text->pop_back();
  if (!from_hex(*text, token_bytes))
    return failure(ErrorCode::bad_input, path.string() + " is no operator token; remove it and a new one is made");
  return text;
}

OperatorGuard::OperatorGuard(const std::string& token, const AttemptLimits& limits, const OperatorRegistry* people)
    : digest_(token.empty() ? "" : sha256(token)), people_(people), attempts_(limits) {}

OperatorGuard::Verdict OperatorGuard::check(std::string_view authorization, const boost::asio::ip::address& from,
                                            AttemptLimiter::Time now, double unix_s, OperatorIdentity* who) {
  constexpr std::string_view scheme = "Bearer ";
  if (who != nullptr) *who = {};
  if (digest_.empty()) return Verdict::welcome;
  if (authorization.empty()) return Verdict::missing;  // nothing was tried
  const bool bearer = authorization.substr(0, scheme.size()) == scheme;
  if (bearer && same_secret(sha256(authorization.substr(scheme.size())), digest_)) return Verdict::welcome;
  const auto known = bearer && people_ != nullptr ? people_->find(authorization.substr(scheme.size())) : std::nullopt;
  if (known && unix_s >= known->expires_s) return Verdict::expired;
  if (known && who != nullptr) *who = *known;
  if (known) return Verdict::welcome;
  const bool may_try = attempts_.allowed(from, now);
  attempts_.failed(from, now);
  return may_try ? Verdict::wrong : Verdict::limited;
}

}  // namespace headframe
