#include "common/security/tls.hpp"

#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <boost/asio/ssl/error.hpp>
#include <cstring>
#include <memory>

#include "common/security/secret.hpp"

namespace headframe {
namespace {

namespace ssl = boost::asio::ssl;

template <auto free_it>
struct Free {
  template <class T>
  void operator()(T* it) const {
    free_it(it);
  }
};
using Bio = std::unique_ptr<BIO, Free<BIO_free_all>>;
using Certificate = std::unique_ptr<X509, Free<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Free<EVP_PKEY_free>>;

Certificate certify(EVP_PKEY* key) {
  constexpr long a_day_s = 24L * 3600;
  Certificate certificate(X509_new());
  X509* c = certificate.get();
  std::uint64_t serial = 0;
  const std::string random = random_secret(sizeof serial);
  std::memcpy(&serial, random.data(), sizeof serial);
  auto* name = c ? X509_get_subject_name(c) : nullptr;
  const bool made =
      c && X509_set_version(c, X509_VERSION_3) == 1 && ASN1_INTEGER_set_uint64(X509_get_serialNumber(c), serial) == 1 &&
      X509_gmtime_adj(X509_getm_notBefore(c), -a_day_s) != nullptr &&
      ASN1_TIME_set_string(X509_getm_notAfter(c), "99991231235959Z") == 1 &&
      X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, reinterpret_cast<const unsigned char*>("headframe"), -1, -1,
                                 0) == 1 &&
      X509_set_issuer_name(c, name) == 1 && X509_set_pubkey(c, key) == 1 && X509_sign(c, key, EVP_sha256()) > 0;
  return made ? std::move(certificate) : nullptr;
}

void only_1_3(ssl::context& context) {
  SSL_CTX_set_min_proto_version(context.native_handle(), TLS1_3_VERSION);
  SSL_CTX_set_max_proto_version(context.native_handle(), TLS1_3_VERSION);
}

}  // namespace

std::string fingerprint_of(const X509* certificate) {
  std::string digest(32, '\0');
  unsigned int size = 0;
  X509_digest(certificate, EVP_sha256(), reinterpret_cast<unsigned char*>(digest.data()), &size);
  return digest;
}

Result<std::string> make_identity() {
  const Key key(EVP_EC_gen("P-256"));
  const Certificate certificate = key ? certify(key.get()) : nullptr;
  const Bio out(BIO_new(BIO_s_mem()));
  if (!certificate || !out ||
      PEM_write_bio_PKCS8PrivateKey(out.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr) != 1 ||
      PEM_write_bio_X509(out.get(), certificate.get()) != 1)
    return failure(ErrorCode::internal, "OpenSSL can not make a key and a certificate");
  const char* data = nullptr;
  const long size = BIO_get_mem_data(out.get(), &data);
  return std::string(data, static_cast<std::size_t>(size));
}

Result<std::string> fingerprint_of(const std::string& pem) {
  const Bio in(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  const Certificate certificate(PEM_read_bio_X509(in.get(), nullptr, nullptr, nullptr));
  if (!certificate) return failure(ErrorCode::bad_input, "there is no certificate in it");
  return fingerprint_of(certificate.get());
}

Result<ssl::context> server_tls(const std::string& pem) {
  ssl::context context(ssl::context::tls_server);
  only_1_3(context);
  SSL_CTX_set_num_tickets(context.native_handle(), 0);
  SSL_CTX_set_session_cache_mode(context.native_handle(), SSL_SESS_CACHE_OFF);
  boost::system::error_code fault;
  context.use_certificate_chain(boost::asio::buffer(pem), fault);
  if (!fault) context.use_private_key(boost::asio::buffer(pem), ssl::context::pem, fault);
  if (fault || SSL_CTX_check_private_key(context.native_handle()) != 1)
    return failure(ErrorCode::bad_input, "no private key with its certificate is in it");
  return context;
}

std::string tls_trouble(const boost::system::error_code& error) {
  if (error.category() != boost::asio::error::get_ssl_category()) return error.message();
  switch (ERR_GET_REASON(static_cast<unsigned long>(error.value()))) {
    case SSL_R_UNSUPPORTED_PROTOCOL:
    case SSL_R_TLSV1_ALERT_PROTOCOL_VERSION: return "the two sides have no version in common; ours is TLS 1.3";
    case SSL_R_WRONG_VERSION_NUMBER:
    case SSL_R_HTTP_REQUEST: return "the other side does not speak TLS";
    case SSL_R_SSLV3_ALERT_CERTIFICATE_UNKNOWN:
    case SSL_R_SSLV3_ALERT_BAD_CERTIFICATE:
    case SSL_R_TLSV1_ALERT_UNKNOWN_CA:
      return "the other side does not trust this certificate; it pins another fingerprint";
    default: return error.message();
  }
}

PinnedTls::PinnedTls(std::string fingerprint) : context_(ssl::context::tls_client), pinned_(std::move(fingerprint)) {
  only_1_3(context_);
  context_.set_verify_mode(ssl::verify_peer);
  SSL_CTX_set_cert_verify_callback(
      context_.native_handle(),
      [](X509_STORE_CTX* store, void* self) {
        return static_cast<PinnedTls*>(self)->accept(X509_STORE_CTX_get0_cert(store)) ? 1 : 0;
      },
      this);
}

bool PinnedTls::accept(void* certificate) {
  const std::string met = fingerprint_of(static_cast<const X509*>(certificate));
  other_ = met == pinned_ ? "" : met;
  return other_.empty();
}

}  // namespace headframe
