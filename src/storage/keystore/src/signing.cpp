// SPDX-License-Identifier: Apache-2.0
#include "signing.hpp"

#include <openssl/err.h>
#include <openssl/pem.h>

#include <string>

namespace pipescout::keystore {
namespace {

constexpr long kVersion3 = 2;
constexpr long kListVersion2 = 1;
constexpr int kSerialBits = 159;  // RFC 5280, 4.1.2.2: at most 20 octets, positive

void require(bool good, const char* what) {
  if (!good) {
    const auto code = ERR_peek_last_error();
    const char* const reason = code == 0 ? nullptr : ERR_reason_error_string(code);
    ERR_clear_error();
    throw KeystoreError(std::string(what) + (reason == nullptr ? "" : std::string(": ") + reason));
  }
}

void add_extension(X509& certificate, X509* issuer, int kind, const char* value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer, &certificate, nullptr, nullptr, 0);
  const OpenSsl<X509_EXTENSION> extension(X509V3_EXT_conf_nid(nullptr, &context, kind, value));
  require(extension != nullptr && X509_add_ext(&certificate, extension.get(), -1) == 1,
          "cannot add an extension to a certificate");
}

OpenSsl<X509> unsigned_certificate(EVP_PKEY& key, const std::string& name,
                                   const Validity& validity) {
  OpenSsl<X509> certificate(X509_new());
  const OpenSsl<BIGNUM> serial(BN_new());
  require(BN_rand(serial.get(), kSerialBits, BN_RAND_TOP_ANY, BN_RAND_BOTTOM_ANY) == 1 &&
              BN_to_ASN1_INTEGER(serial.get(), X509_get_serialNumber(certificate.get())) != nullptr,
          "cannot make a serial number");
  X509_NAME* const subject = X509_get_subject_name(certificate.get());
  require(
      X509_set_version(certificate.get(), kVersion3) == 1 &&
          ASN1_TIME_set(X509_getm_notBefore(certificate.get()), validity.not_before) != nullptr &&
          ASN1_TIME_set(X509_getm_notAfter(certificate.get()), validity.not_after) != nullptr &&
          X509_set_pubkey(certificate.get(), &key) == 1,
      "cannot make a certificate");
  require(X509_NAME_add_entry_by_NID(subject, NID_commonName, MBSTRING_UTF8,
                                     reinterpret_cast<const unsigned char*>(name.data()),
                                     static_cast<int>(name.size()), -1, 0) == 1,
          "cannot name a certificate");
  return certificate;
}

void sign_list(X509_CRL& list, EVP_PKEY& authority_key) {
  require(X509_CRL_sort(&list) == 1 && X509_CRL_sign(&list, &authority_key, EVP_sha256()) > 0,
          "cannot sign the revocation list");
}

}  // namespace

Key make_key() {
  Key key(EVP_EC_gen("P-256"));
  require(key != nullptr, "cannot make a key");
  return key;
}

Certificate make_authority(EVP_PKEY& key, const std::string& name, const Validity& validity) {
  OpenSsl<X509> certificate = unsigned_certificate(key, name, validity);
  add_extension(*certificate, certificate.get(), NID_basic_constraints,
                "critical,CA:TRUE,pathlen:1");
  add_extension(*certificate, certificate.get(), NID_subject_key_identifier, "hash");
  require(X509_set_issuer_name(certificate.get(), X509_get_subject_name(certificate.get())) == 1 &&
              X509_sign(certificate.get(), &key, EVP_sha256()) > 0,
          "cannot sign a certificate");
  return Certificate(certificate.release());
}

Certificate make_certificate(EVP_PKEY& key, const std::string& name, const Validity& validity,
                             const Certificate& authority, EVP_PKEY& authority_key) {
  OpenSsl<X509> certificate = unsigned_certificate(key, name, validity);
  require(X509_set_issuer_name(certificate.get(), X509_get_subject_name(&authority.handle())) == 1,
          "cannot name the authority in a certificate");
  add_extension(*certificate, &authority.handle(), NID_basic_constraints, "critical,CA:FALSE");
  require(X509_sign(certificate.get(), &authority_key, EVP_sha256()) > 0,
          "cannot sign a certificate");
  return Certificate(certificate.release());
}

std::string sign(const std::string& document, const Certificate& authority,
                 EVP_PKEY& authority_key) {
  constexpr int kFlags = PKCS7_TEXT | PKCS7_DETACHED;
  const auto input = reader_of(document);
  const OpenSsl<PKCS7> signature(
      PKCS7_sign(&authority.handle(), &authority_key, nullptr, input.get(), kFlags));
  const OpenSsl<BIO> output(BIO_new(BIO_s_mem()));
  const auto again = reader_of(document);
  require(signature != nullptr &&
              SMIME_write_PKCS7(output.get(), signature.get(), again.get(), kFlags) == 1,
          "cannot sign a document");
  return text_of(*output);
}

RevocationList make_revocation_list(const Certificate& authority, EVP_PKEY& authority_key,
                                    std::time_t now) {
  OpenSsl<X509_CRL> list(X509_CRL_new());
  const OpenSsl<ASN1_TIME> today(ASN1_TIME_set(nullptr, now));
  // Valid as long as the authority: a robot that has been away must not fall silent.
  require(
      X509_CRL_set_version(list.get(), kListVersion2) == 1 &&
          X509_CRL_set_issuer_name(list.get(), X509_get_subject_name(&authority.handle())) == 1 &&
          X509_CRL_set1_lastUpdate(list.get(), today.get()) == 1 &&
          X509_CRL_set1_nextUpdate(list.get(), X509_get0_notAfter(&authority.handle())) == 1,
      "cannot make a revocation list");
  sign_list(*list, authority_key);
  return RevocationList(list.release());
}

bool add_revoked(const RevocationList& list, const Certificate& certificate,
                 const Certificate& authority, EVP_PKEY& authority_key, std::time_t now) {
  if (list.revoked_since(certificate)) {
    return false;
  }
  require(list.is_signed_by(authority),
          "the revocation list is not signed by the authority of the identities");
  const OpenSsl<ASN1_TIME> today(ASN1_TIME_set(nullptr, now));
  OpenSsl<X509_REVOKED> entry(X509_REVOKED_new());
  require(X509_REVOKED_set_serialNumber(entry.get(),
                                        X509_get_serialNumber(&certificate.handle())) == 1 &&
              X509_REVOKED_set_revocationDate(entry.get(), today.get()) == 1 &&
              X509_CRL_add0_revoked(&list.handle(), entry.get()) == 1,
          "cannot revoke a certificate");
  static_cast<void>(entry.release());  // the list has it
  require(X509_CRL_set1_lastUpdate(&list.handle(), today.get()) == 1,
          "cannot date the revocation list");
  sign_list(list.handle(), authority_key);
  return true;
}

std::string to_pem(EVP_PKEY& key) {
  const OpenSsl<BIO> output(BIO_new(BIO_s_mem()));
  require(PEM_write_bio_PrivateKey(output.get(), &key, nullptr, nullptr, 0, nullptr, nullptr) == 1,
          "cannot write a key");
  return text_of(*output);
}

std::string to_pem(const Certificate& certificate) {
  const OpenSsl<BIO> output(BIO_new(BIO_s_mem()));
  require(PEM_write_bio_X509(output.get(), &certificate.handle()) == 1,
          "cannot write a certificate");
  return text_of(*output);
}

std::string to_pem(const RevocationList& list) {
  const OpenSsl<BIO> output(BIO_new(BIO_s_mem()));
  require(PEM_write_bio_X509_CRL(output.get(), &list.handle()) == 1,
          "cannot write a revocation list");
  return text_of(*output);
}

Key read_key(const std::string& pem) {
  Key key(PEM_read_bio_PrivateKey(reader_of(pem).get(), nullptr, refuse_passphrase, nullptr));
  ERR_clear_error();
  require(key != nullptr, "is no private key (PEM, without a passphrase)");
  return key;
}

}  // namespace pipescout::keystore
