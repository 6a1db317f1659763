#pragma once

#include <string>
#include <string_view>

#include "common/result.hpp"

namespace headframe {

/// What an operator gives to a robot so that it can enrol; as one string to paste, "hf1-" + 64 hexadecimal digits + "-"
/// + 32 hexadecimal digits.
struct Enrolment {
  std::string fingerprint;  // 32 bytes, SHA-256 of the certificate (DER) of the server to trust
  std::string code;         // 16 bytes, valid once, for one robot
};

/// The message of bad_input never repeats the text, which may be most of a code.
Result<Enrolment> parse_enrolment(std::string_view text);
std::string to_string(const Enrolment& enrolment);

/// Parses a fingerprint: 64 hexadecimal digits, optionally with colons between the bytes, as openssl prints it.
Result<std::string> parse_fingerprint(std::string_view text);

}  // namespace headframe
