#include "common/security/web_tls.hpp"

#include <arpa/inet.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include "common/security/tls.hpp"

namespace headframe {

namespace ssl = boost::asio::ssl;

WebTls::WebTls(WebTrust trust) : trust_(std::move(trust)), context_(ssl::context::tls_client) {
  SSL_CTX_set_min_proto_version(context_.native_handle(), TLS1_3_VERSION);
  context_.set_verify_mode(ssl::verify_peer);
  SSL_CTX_set_cert_verify_callback(
      context_.native_handle(),
      [](X509_STORE_CTX* chain, void* self) { return static_cast<WebTls*>(self)->accept(chain) ? 1 : 0; }, this);
}

Result<std::unique_ptr<WebTls>> WebTls::make(const WebTrust& trust) {
  std::unique_ptr<WebTls> made(new WebTls(trust));
  boost::system::error_code fault;
  if (trust.authorities.empty()) {
    made->context_.set_default_verify_paths(fault);  // a system without authorities trusts nobody
    return made;
  }
  if (!std::filesystem::exists(trust.authorities))
    return failure(ErrorCode::not_found, trust.authorities.string() + " is not there");
  made->context_.load_verify_file(trust.authorities.string(), fault);
  if (fault) return failure(ErrorCode::bad_input, trust.authorities.string() + " has no certificate in PEM");
  return made;
}

void WebTls::ask_for(SSL* connection, const std::string& host) {
  in6_addr address{};
  X509_VERIFY_PARAM* wanted = SSL_get0_param(connection);
  if (::inet_pton(AF_INET, host.c_str(), &address) == 1 || ::inet_pton(AF_INET6, host.c_str(), &address) == 1) {
    X509_VERIFY_PARAM_set1_ip_asc(wanted, host.c_str());
    return;
  }
  X509_VERIFY_PARAM_set1_host(wanted, host.c_str(), host.size());
  SSL_set_tlsext_host_name(connection, host.c_str());
}

bool WebTls::accept(X509_STORE_CTX* chain) {
  const std::string met = fingerprint_of(X509_STORE_CTX_get0_cert(chain));
  const bool pinned = !trust_.fingerprint.empty() && met == trust_.fingerprint;
  const bool others_may = trust_.fingerprint.empty() || !trust_.fingerprint_only;
  const bool accepted = pinned || (others_may && X509_verify_cert(chain) == 1);
  if (accepted) X509_STORE_CTX_set_error(chain, X509_V_OK);
  refused_ = accepted ? "" : met;
  return accepted;
}

}  // namespace headframe
