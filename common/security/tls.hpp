#pragma once
// Both ends of our TLS: version 1.3 and nothing else, the server known by its certificate's fingerprint alone.

#include <boost/asio/ssl/context.hpp>
#include <string>

#include "common/result.hpp"

namespace headframe {

/// A private key and its self-signed certificate, as PEM. There is no authority behind it and no name in it that
/// counts: clients know its fingerprint.
Result<std::string> make_identity();

/// SHA-256 of the DER of the certificate in `pem`: 32 bytes. bad_input: there is none.
Result<std::string> fingerprint_of(const std::string& pem);

/// The same of a certificate that OpenSSL holds.
std::string fingerprint_of(const X509* certificate);

/// For servers. `pem` has a private key and its certificate, with those of its issuers after it if there are any. No
/// session tickets: a robot reconnects seldom, and they cost bytes. bad_input: no key or certificate in `pem`, or they
/// do not fit each other.
Result<boost::asio::ssl::context> server_tls(const std::string& pem);

/// For clients: lets a handshake succeed with the server of this fingerprint only. Dates, names and issuers are not
/// looked at: a robot's clock may be wrong, and the pin says all. Handshakes of one context must not overlap.
class PinnedTls {
 public:
  explicit PinnedTls(std::string fingerprint);
  PinnedTls(const PinnedTls&) = delete;
  PinnedTls& operator=(const PinnedTls&) = delete;

  boost::asio::ssl::context& context() { return context_; }

  /// The other fingerprint that the last handshake has met; empty: it was the pinned one, or none was seen.
  const std::string& other() const { return other_; }

 private:
  bool accept(void* certificate);

  boost::asio::ssl::context context_;
  const std::string pinned_;
  std::string other_;
};

/// Why a handshake or a read failed, in words for people.
std::string tls_trouble(const boost::system::error_code& error);

}  // namespace headframe
