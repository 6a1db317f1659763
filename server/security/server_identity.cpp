#include "server/security/server_identity.hpp"

#include <fstream>
#include <iterator>

#include "common/security/private_file.hpp"
#include "common/security/tls.hpp"

namespace headframe {

Result<ServerIdentity> server_identity(const std::filesystem::path& directory, bool may_be_made) {
  const auto path = directory / "identity.pem";
  auto pem = read_private_file(path);
  if (!pem && pem.error().code == ErrorCode::not_found) {
    if (!may_be_made)
      return failure(ErrorCode::refused, path.string() +
                                             " is missing, by which the enrolled robots know this server: restore it "
                                             "from a copy, or give --new-identity once and enrol all robots anew");
    pem = make_identity();
    if (!pem) return tl::unexpected(pem.error());
    if (auto written = write_private_file(path, *pem); !written) return tl::unexpected(written.error());
  }
  if (!pem) return tl::unexpected(pem.error());
  auto tls = server_tls(*pem);
  auto fingerprint = fingerprint_of(*pem);
  if (!tls || !fingerprint)
    return failure(ErrorCode::bad_input, path.string() + ": " + (tls ? fingerprint.error() : tls.error()).message +
                                             "; restore it from a copy, or remove it and enrol all robots anew");
  return ServerIdentity{std::move(*tls), std::move(*fingerprint)};
}

Result<ServerIdentity> given_identity(const std::filesystem::path& certificate, const std::filesystem::path& key) {
  auto pem = read_private_file(key.empty() ? certificate : key);
  if (!pem) return tl::unexpected(pem.error());
  if (!key.empty()) {  // the certificate is no secret
    std::ifstream file(certificate, std::ios::binary);
    if (!file) return failure(ErrorCode::not_found, certificate.string() + " can not be read");
    pem->insert(0, std::string(std::istreambuf_iterator<char>(file), {}) + "\n");
  }
  auto tls = server_tls(*pem);
  auto fingerprint = fingerprint_of(*pem);
  if (!tls || !fingerprint)
    return failure(ErrorCode::bad_input, certificate.string() + (key.empty() ? "" : " and " + key.string()) + ": " +
                                             (tls ? fingerprint.error() : tls.error()).message);
  return ServerIdentity{std::move(*tls), std::move(*fingerprint)};
}

}  // namespace headframe
