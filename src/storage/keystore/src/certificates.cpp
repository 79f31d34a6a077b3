// SPDX-License-Identifier: Apache-2.0
#include "pipescout/keystore/certificates.hpp"

#include <openssl/err.h>
#include <openssl/pem.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <string_view>

#include "openssl_handles.hpp"
#include "pipescout/files/utc_text.hpp"

namespace pipescout::keystore {
namespace {

std::time_t to_time(const ASN1_TIME* time, const char* what) {
  std::tm parts{};
  if (time == nullptr || ASN1_TIME_to_tm(time, &parts) != 1) {
    throw KeystoreError(std::string("has no valid ") + what);
  }
  return timegm(&parts);
}

/// "2027-11-26T12:00:00" of XML, in UTC.
std::time_t to_time(const std::string& text) {
  std::tm parts{};
  const char* const end = strptime(text.c_str(), "%Y-%m-%dT%H:%M:%S", &parts);
  if (end == nullptr || (*end != '\0' && std::string_view(end) != "Z")) {
    throw KeystoreError("'" + text + "' is no date such as 2027-11-26T12:00:00");
  }
  return timegm(&parts);
}

/// The texts of all elements of this name; they have no attributes.
std::vector<std::string> elements(const std::string& document, const std::string& name) {
  const std::string begin = "<" + name + ">";
  const std::string end = "</" + name + ">";
  std::vector<std::string> texts;
  std::size_t position = 0;
  while ((position = document.find(begin, position)) != std::string::npos) {
    position += begin.size();
    const auto stop = document.find(end, position);
    if (stop == std::string::npos) {
      throw KeystoreError("<" + name + "> without an end");
    }
    const std::string_view text = std::string_view(document).substr(position, stop - position);
    const auto first = text.find_first_not_of(" \t\r\n");
    const auto last = text.find_last_not_of(" \t\r\n");
    texts.emplace_back(first == std::string_view::npos ? std::string_view{}
                                                       : text.substr(first, last - first + 1));
  }
  return texts;
}

}  // namespace

std::string date_text(std::time_t time) {
  return utc_text(std::chrono::sys_seconds(std::chrono::seconds(time)), UtcForm::kReadable);
}

Certificate::Certificate(const std::string& pem)
    : certificate_(PEM_read_bio_X509(reader_of(pem).get(), nullptr, refuse_passphrase, nullptr),
                   X509_free) {
  ERR_clear_error();
  if (certificate_ == nullptr) {
    throw KeystoreError("is no certificate (PEM)");
  }
}

Certificate::Certificate(x509_st* certificate) : certificate_(certificate, X509_free) {}

Validity Certificate::validity() const {
  return {to_time(X509_get0_notBefore(certificate_.get()), "start of validity"),
          to_time(X509_get0_notAfter(certificate_.get()), "end of validity")};
}

bool Certificate::is_signed_by(const Certificate& authority) const {
  const bool valid = X509_verify(certificate_.get(), X509_get0_pubkey(&authority.handle())) == 1;
  ERR_clear_error();
  return valid;
}

bool Certificate::is_same_as(const Certificate& other) const {
  return X509_cmp(certificate_.get(), other.certificate_.get()) == 0;
}

bool Certificate::fits_key(const std::string& key) const {
  const OpenSsl<EVP_PKEY> loaded(
      PEM_read_bio_PrivateKey(reader_of(key).get(), nullptr, refuse_passphrase, nullptr));
  const bool fits =
      loaded != nullptr && X509_check_private_key(certificate_.get(), loaded.get()) == 1;
  ERR_clear_error();
  return fits;
}

std::optional<std::string> Certificate::verified(const std::string& message) const {
  BIO* detached = nullptr;
  const OpenSsl<PKCS7> signature(SMIME_read_PKCS7(reader_of(message).get(), &detached));
  const OpenSsl<BIO> document(detached);
  const OpenSsl<BIO> output(BIO_new(BIO_s_mem()));
  const OpenSsl<STACK_OF(X509)> signers(sk_X509_new_null());
  sk_X509_push(signers.get(), certificate_.get());
  // As Fast DDS does: the authority itself has signed, whatever certificates the message brings.
  const bool valid = signature != nullptr &&
                     PKCS7_verify(signature.get(), signers.get(), nullptr, document.get(),
                                  output.get(), PKCS7_TEXT | PKCS7_NOVERIFY | PKCS7_NOINTERN) == 1;
  ERR_clear_error();
  return valid ? std::optional(text_of(*output)) : std::nullopt;
}

RevocationList::RevocationList(const std::string& pem)
    : list_(PEM_read_bio_X509_CRL(reader_of(pem).get(), nullptr, refuse_passphrase, nullptr),
            X509_CRL_free) {
  ERR_clear_error();
  if (list_ == nullptr) {
    throw KeystoreError("is no certificate revocation list (PEM)");
  }
}

RevocationList::RevocationList(X509_crl_st* list) : list_(list, X509_CRL_free) {}

Validity RevocationList::validity() const {
  const ASN1_TIME* const next = X509_CRL_get0_nextUpdate(list_.get());
  return {to_time(X509_CRL_get0_lastUpdate(list_.get()), "date"),
          next == nullptr ? std::numeric_limits<std::time_t>::max() : to_time(next, "next date")};
}

bool RevocationList::is_signed_by(const Certificate& authority) const {
  const bool valid = X509_CRL_verify(list_.get(), X509_get0_pubkey(&authority.handle())) == 1;
  ERR_clear_error();
  return valid;
}

std::optional<std::time_t> RevocationList::revoked_since(const Certificate& certificate) const {
  X509_REVOKED* entry = nullptr;
  if (X509_CRL_get0_by_cert(list_.get(), &entry, &certificate.handle()) != 1) {
    return std::nullopt;
  }
  return to_time(X509_REVOKED_get0_revocationDate(entry), "date of a revocation");
}

std::vector<Validity> validities_in(const std::string& document) {
  const auto starts = elements(document, "not_before");
  const auto ends = elements(document, "not_after");
  if (starts.size() != ends.size()) {
    throw KeystoreError("a validity needs both <not_before> and <not_after>");
  }
  std::vector<Validity> validities;
  for (std::size_t k = 0; k < starts.size(); ++k) {
    validities.push_back({to_time(starts[k]), to_time(ends[k])});
  }
  return validities;
}

bool grants_any_partition(const std::string& document) {
  const auto partitions = elements(document, "partition");
  return std::find(partitions.begin(), partitions.end(), kAnyPartition) != partitions.end();
}

}  // namespace pipescout::keystore
