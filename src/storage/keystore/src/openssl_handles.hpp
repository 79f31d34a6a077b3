// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <openssl/bio.h>
#include <openssl/bn.h>
#include <openssl/evp.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <memory>
#include <string>

namespace pipescout::keystore {

struct OpenSslDeleter {
  void operator()(ASN1_TIME* time) const { ASN1_TIME_free(time); }
  void operator()(BIGNUM* number) const { BN_free(number); }
  void operator()(BIO* bio) const { BIO_free(bio); }
  void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
  void operator()(PKCS7* message) const { PKCS7_free(message); }
  void operator()(STACK_OF(X509) * certificates) const { sk_X509_free(certificates); }
  void operator()(X509* certificate) const { X509_free(certificate); }
  void operator()(X509_CRL* list) const { X509_CRL_free(list); }
  void operator()(X509_EXTENSION* extension) const { X509_EXTENSION_free(extension); }
  void operator()(X509_REVOKED* entry) const { X509_REVOKED_free(entry); }
};

template <class T>
using OpenSsl = std::unique_ptr<T, OpenSslDeleter>;

/// Reads the text, which must outlive it.
[[nodiscard]] inline OpenSsl<BIO> reader_of(const std::string& text) {
  return OpenSsl<BIO>(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

/// What was written to one in memory.
[[nodiscard]] inline std::string text_of(BIO& bio) {
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(&bio, &bytes);
  return {bytes, static_cast<std::size_t>(size)};
}

/// A key with a passphrase cannot be read: OpenSSL would ask for it on the terminal.
inline int refuse_passphrase(char*, int, int, void*) {
  return -1;
}

}  // namespace pipescout::keystore
