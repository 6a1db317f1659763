#pragma once
// Random secrets and their digests. All functions are thread safe.

#include <cstddef>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace headframe {

inline constexpr std::size_t token_bytes = 32;  // of a robot's or an operator's token
inline constexpr std::size_t code_bytes = 16;   // of a one-time enrolment code

/// Bytes from the system's cryptographic generator. Throws std::runtime_error if there is none, which must stop the
/// program.
std::string random_secret(std::size_t bytes);

/// 32 bytes. Sufficient for storing a secret that is itself random and long, because it cannot be guessed.
std::string sha256(std::string_view bytes);

/// HMAC-SHA256 (RFC 2104), 32 bytes. Only the holders of the key can make it.
std::string hmac_sha256(std::string_view key, std::string_view bytes);

/// Whether the bytes are equal; the time taken depends only on the length.
bool same_secret(std::string_view a, std::string_view b);

/// Lower-case hexadecimal, and back; bad_input never repeats the text.
std::string to_hex(std::string_view bytes);
Result<std::string> from_hex(std::string_view text, std::size_t bytes);

}  // namespace headframe
