#include "common/security/enrolment.hpp"

#include <algorithm>

#include "common/security/secret.hpp"

namespace headframe {
namespace {

constexpr std::string_view prefix = "hf1-";
constexpr std::size_t fingerprint_bytes = 32;

}  // namespace

Result<Enrolment> parse_enrolment(std::string_view text) {
  const auto bad = [] {
    return failure(ErrorCode::bad_input,
                   "this is no enrolment: paste the whole of what `headframe robot add` printed, hf1-...");
  };
  if (text.substr(0, prefix.size()) != prefix) return bad();
  text.remove_prefix(prefix.size());
  const auto dash = text.find('-');
  if (dash == std::string_view::npos) return bad();
  auto fingerprint = from_hex(text.substr(0, dash), fingerprint_bytes);
  auto code = from_hex(text.substr(dash + 1), code_bytes);
  if (!fingerprint || !code) return bad();
  return Enrolment{std::move(*fingerprint), std::move(*code)};
}

std::string to_string(const Enrolment& enrolment) {
  return std::string(prefix) + to_hex(enrolment.fingerprint) + "-" + to_hex(enrolment.code);
}

Result<std::string> parse_fingerprint(std::string_view text) {
  std::string digits(text);
  std::erase(digits, ':');
  auto fingerprint = from_hex(digits, fingerprint_bytes);
  if (!fingerprint)
    return failure(ErrorCode::bad_input, "a fingerprint is 64 hexadecimal digits, as headframe-server prints at start");
  return fingerprint;
}

}  // namespace headframe
