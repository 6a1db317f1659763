#pragma once

#include <string>
#include <string_view>

#include "common/result.hpp"

namespace headframe {

/// What an operator hands to a robot so that it can enrol: one string to paste,
/// "hf1-" + 64 hexadecimal digits + "-" + 32 hexadecimal digits.
struct Enrolment {
  std::string fingerprint;  // 32 bytes, SHA-256 of the server's certificate (DER): whom to trust
  std::string code;         // 16 bytes, good for one robot and one time
};

/// bad_input never repeats what was given: it may be most of a code.
Result<Enrolment> parse_enrolment(std::string_view text);
std::string to_string(const Enrolment& enrolment);

/// A fingerprint as people see it: 64 hexadecimal digits, also read with colons between the bytes as openssl prints it.
Result<std::string> parse_fingerprint(std::string_view text);

}  // namespace headframe
