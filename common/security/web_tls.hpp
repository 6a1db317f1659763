#pragma once
// A client's end of HTTPS: whom it takes for the server.

#include <boost/asio/ssl/context.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "common/result.hpp"

namespace headframe {

struct WebTrust {
  std::string fingerprint = {};            // SHA-256 of the server's certificate, 32 bytes; empty: none is known
  std::filesystem::path authorities = {};  // PEM file of those who may vouch for it; empty: the system's
  bool fingerprint_only = true;            // where there is one, nobody else may vouch
};

/// TLS 1.3 to a server with the pinned fingerprint, whatever else its certificate says; or, where none is pinned, to
/// one whose certificate an authority gave to the host that was asked for. For one connection at a time. Not thread
/// safe.
class WebTls {
 public:
  /// not_found: the file of the authorities can not be read; bad_input: there is no certificate in it.
  static Result<std::unique_ptr<WebTls>> make(const WebTrust& trust);
  WebTls(const WebTls&) = delete;
  WebTls& operator=(const WebTls&) = delete;

  boost::asio::ssl::context& context() { return context_; }
  /// Of a connection that is about to shake hands: the host, a name or an address, that was asked for.
  static void ask_for(SSL* connection, const std::string& host);
  /// The fingerprint of the certificate that the last handshake refused; empty: none was.
  const std::string& refused() const { return refused_; }

 private:
  explicit WebTls(WebTrust trust);
  bool accept(X509_STORE_CTX* chain);

  const WebTrust trust_;
  boost::asio::ssl::context context_;
  std::string refused_;
};

}  // namespace headframe
