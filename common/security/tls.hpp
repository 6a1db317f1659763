#pragma once
// Both ends of our TLS: only version 1.3, and the server is authenticated only by its certificate's fingerprint.

#include <boost/asio/ssl/context.hpp>
#include <string>

#include "common/result.hpp"

namespace headframe {

/// A private key and its self-signed certificate, as PEM. No authority has signed it and its names do not matter:
/// clients know its fingerprint.
Result<std::string> make_identity();

/// SHA-256 of the DER of the certificate in `pem`: 32 bytes. bad_input: there is no certificate.
Result<std::string> fingerprint_of(const std::string& pem);

/// The same for a certificate held by OpenSSL.
std::string fingerprint_of(const X509* certificate);

/// For servers. `pem` has a private key and its certificate, optionally followed by those of its issuers. Session
/// tickets are off: a robot seldom reconnects, and they cost bytes. bad_input: no key or certificate in `pem`, or they
/// do not belong together.
Result<boost::asio::ssl::context> server_tls(const std::string& pem);

/// For clients: a handshake succeeds only with the server that has this fingerprint. Dates, names and issuers are
/// ignored: a robot's clock may be wrong, and the fingerprint suffices. Handshakes of one context must not overlap.
class PinnedTls {
 public:
  explicit PinnedTls(std::string fingerprint);
  PinnedTls(const PinnedTls&) = delete;
  PinnedTls& operator=(const PinnedTls&) = delete;

  boost::asio::ssl::context& context() { return context_; }

  /// The fingerprint that the last handshake met instead of the pinned one; empty if it met the pinned one or none.
  const std::string& other() const { return other_; }

 private:
  bool accept(void* certificate);

  boost::asio::ssl::context context_;
  const std::string pinned_;
  std::string other_;
};

/// Why a handshake or a read failed, in words.
std::string tls_trouble(const boost::system::error_code& error);

}  // namespace headframe
