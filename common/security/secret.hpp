#pragma once
// Random secrets and what is kept of them. All functions are thread safe.

#include <cstddef>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace headframe {

inline constexpr std::size_t token_bytes = 32;  // of a robot's or an operator's token
inline constexpr std::size_t code_bytes = 16;   // of a one-time enrolment code

/// Bytes of the system's cryptographic generator. Throws std::runtime_error when it has none: nothing may go on then.
std::string random_secret(std::size_t bytes);

/// 32 bytes. Enough to store a secret by when the secret itself is random and long: there is nothing to guess.
std::string sha256(std::string_view bytes);

/// HMAC-SHA256 (RFC 2104), 32 bytes: who does not have the key can not make it.
std::string hmac_sha256(std::string_view key, std::string_view bytes);

/// True for equal bytes, in a time that depends on the length alone.
bool same_secret(std::string_view a, std::string_view b);

/// Lower-case hexadecimal, and back; bad_input says only that it is none, never what was there.
std::string to_hex(std::string_view bytes);
Result<std::string> from_hex(std::string_view text, std::size_t bytes);

}  // namespace headframe
