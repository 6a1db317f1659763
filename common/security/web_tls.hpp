#pragma once
// The client's side of HTTPS: how it authenticates the server.

#include <boost/asio/ssl/context.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "common/result.hpp"

namespace headframe {

struct WebTrust {
  std::string fingerprint = {};            // SHA-256 of the server's certificate, 32 bytes; empty: not known
  std::filesystem::path authorities = {};  // PEM file with trusted authorities; empty: the system's
  bool fingerprint_only = true;            // if there is a fingerprint, authorities are not accepted
};

/// TLS 1.3 to a server with the pinned fingerprint, whatever else its certificate says; or, if none is pinned, to one
/// whose certificate was issued by an authority for the requested host. For one connection at a time. Not thread safe.
class WebTls {
 public:
  /// not_found: the file with the authorities cannot be read; bad_input: it contains no certificate.
  static Result<std::unique_ptr<WebTls>> make(const WebTrust& trust);
  WebTls(const WebTls&) = delete;
  WebTls& operator=(const WebTls&) = delete;

  boost::asio::ssl::context& context() { return context_; }
  /// Call before the handshake: sets the requested host, a name or an address.
  static void ask_for(SSL* connection, const std::string& host);
  /// The fingerprint of the certificate that the last handshake refused; empty: none.
  const std::string& refused() const { return refused_; }

 private:
  explicit WebTls(WebTrust trust);
  bool accept(X509_STORE_CTX* chain);

  const WebTrust trust_;
  boost::asio::ssl::context context_;
  std::string refused_;
};

}  // namespace headframe
