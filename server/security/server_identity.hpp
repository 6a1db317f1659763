#pragma once

#include <boost/asio/ssl/context.hpp>
#include <filesystem>
#include <string>

#include "common/result.hpp"

namespace headframe {

struct ServerIdentity {
  boost::asio::ssl::context tls;
  std::string fingerprint;  // 32 bytes; robots recognise the server by it
};

/// The key and certificate in DIRECTORY/identity.pem (mode 0600), which is created if it does not exist and
/// may_be_made. Whoever has this file can pretend to be this server; without it no robot recognises the server. Fails
/// like read_private_file, except not_found; refused: it is missing and may not be created; bad_input: it has other
/// content.
Result<ServerIdentity> server_identity(const std::filesystem::path& directory, bool may_be_made);

/// A certificate issued by an authority, followed by those of its issuers, and its private key, as PEM files; `key` may
/// be empty if both are in one file. Only the owner may have access to the file with the key. not_found, unavailable: a
/// file cannot be read; refused: others can read the key; bad_input: wrong content, or key and certificate do not
/// belong together.
Result<ServerIdentity> given_identity(const std::filesystem::path& certificate, const std::filesystem::path& key);

}  // namespace headframe
