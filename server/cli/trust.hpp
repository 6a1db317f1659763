#pragma once

#include <string>

#include "common/result.hpp"
#include "common/security/web_tls.hpp"

namespace headframe {

/// Whom to take for the server: the one with this fingerprint (64 hexadecimal digits, colons between them or not), if
/// it is not empty; else one that somebody of the PEM file `authorities` vouches for, or, where that is empty too, the
/// system's authorities, or whose certificate lies beside the operator's token, as it does on the server's own machine.
/// `token_file`: as find_token's. invalid_argument: it is no fingerprint, or both are given.
Result<WebTrust> find_trust(std::string fingerprint, const std::string& authorities, const std::string& token_file);

}  // namespace headframe
