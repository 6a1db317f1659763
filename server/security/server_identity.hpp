#pragma once

#include <boost/asio/ssl/context.hpp>
#include <filesystem>
#include <string>

#include "common/result.hpp"

namespace headframe {

struct ServerIdentity {
  boost::asio::ssl::context tls;
  std::string fingerprint;  // 32 bytes: by this robots know the server
};

/// The key and certificate of DIRECTORY/identity.pem (mode 0600); made when it is not there and may be. Whoever has
/// this file can pretend to be this server; without it no robot knows the server again. Errors are those of
/// read_private_file, but not_found; refused: it is missing and may not be made; bad_input: something else is in it.
Result<ServerIdentity> server_identity(const std::filesystem::path& directory, bool may_be_made);

/// A certificate that an authority gave, with those of its issuers after it, and its private key: PEM files; `key` may
/// be empty when both are in one. The file with the key has to be its owner's alone. not_found, unavailable: a file can
/// not be read; refused: others can read the key; bad_input: something else is in it, or they do not fit each other.
Result<ServerIdentity> given_identity(const std::filesystem::path& certificate, const std::filesystem::path& key);

}  // namespace headframe
