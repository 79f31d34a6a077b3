// SPDX-License-Identifier: Apache-2.0
#include "security_files.hpp"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>

#include <limits>
#include <string_view>

namespace pipescout::dds {
namespace {

struct Free {
  void operator()(BIO* bio) const { BIO_free(bio); }
  void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
  void operator()(PKCS7* message) const { PKCS7_free(message); }
  void operator()(STACK_OF(X509) * certificates) const { sk_X509_free(certificates); }
};
using Bio = std::unique_ptr<BIO, Free>;
using Key = std::unique_ptr<EVP_PKEY, Free>;

Bio reader(const std::string& text) {
  return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

/// A private key with a passphrase is none here: OpenSSL would ask for it on the terminal.
int no_passphrase(char*, int, int, void*) {
  return -1;
}

std::time_t to_time(const ASN1_TIME* time, const char* what) {
  std::tm parts{};
  if (time == nullptr || ASN1_TIME_to_tm(time, &parts) != 1) {
    throw SecurityFileError(std::string("has no valid ") + what);
  }
  return timegm(&parts);
}

/// "2027-11-26T12:00:00" of XML, in UTC.
std::time_t to_time(const std::string& text) {
  std::tm parts{};
  const char* const end = strptime(text.c_str(), "%Y-%m-%dT%H:%M:%S", &parts);
  if (end == nullptr || (*end != '\0' && std::string_view(end) != "Z")) {
    throw SecurityFileError("'" + text + "' is no date such as 2027-11-26T12:00:00");
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
      throw SecurityFileError("<" + name + "> without an end");
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

std::string utc_text(std::time_t time) {
  std::tm parts{};
  gmtime_r(&time, &parts);
  std::string text(32, '\0');
  text.resize(std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S UTC", &parts));
  return text;
}

Certificate::Certificate(const std::string& pem)
    : certificate_(PEM_read_bio_X509(reader(pem).get(), nullptr, no_passphrase, nullptr),
                   X509_free) {
  ERR_clear_error();
  if (certificate_ == nullptr) {
    throw SecurityFileError("is no certificate (PEM)");
  }
}

Validity Certificate::validity() const {
  return {to_time(X509_get0_notBefore(certificate_.get()), "start of validity"),
          to_time(X509_get0_notAfter(certificate_.get()), "end of validity")};
}

bool Certificate::is_signed_by(const Certificate& authority) const {
  const bool valid =
      X509_verify(certificate_.get(), X509_get0_pubkey(authority.certificate_.get())) == 1;
  ERR_clear_error();
  return valid;
}

bool Certificate::fits_key(const std::string& key) const {
  const Key loaded(PEM_read_bio_PrivateKey(reader(key).get(), nullptr, no_passphrase, nullptr));
  const bool fits =
      loaded != nullptr && X509_check_private_key(certificate_.get(), loaded.get()) == 1;
  ERR_clear_error();
  return fits;
}

std::optional<std::string> Certificate::verified(const std::string& message) const {
  BIO* detached = nullptr;
  const std::unique_ptr<PKCS7, Free> signature(SMIME_read_PKCS7(reader(message).get(), &detached));
  const Bio document(detached);
  const Bio verified(BIO_new(BIO_s_mem()));
  const std::unique_ptr<STACK_OF(X509), Free> signers(sk_X509_new_null());
  sk_X509_push(signers.get(), certificate_.get());
  // As Fast DDS does: the authority itself has signed, whatever certificates the message brings.
  const bool valid =
      signature != nullptr &&
      PKCS7_verify(signature.get(), signers.get(), nullptr, document.get(), verified.get(),
                   PKCS7_TEXT | PKCS7_NOVERIFY | PKCS7_NOINTERN) == 1;
  ERR_clear_error();
  if (!valid) {
    return std::nullopt;
  }
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(verified.get(), &bytes);
  return std::string(bytes, static_cast<std::size_t>(size));
}

RevocationList::RevocationList(const std::string& pem)
    : list_(PEM_read_bio_X509_CRL(reader(pem).get(), nullptr, no_passphrase, nullptr),
            X509_CRL_free) {
  ERR_clear_error();
  if (list_ == nullptr) {
    throw SecurityFileError("is no certificate revocation list (PEM)");
  }
}

Validity RevocationList::validity() const {
  const ASN1_TIME* const next = X509_CRL_get0_nextUpdate(list_.get());
  return {to_time(X509_CRL_get0_lastUpdate(list_.get()), "date"),
          next == nullptr ? std::numeric_limits<std::time_t>::max() : to_time(next, "next date")};
}

bool RevocationList::is_signed_by(const Certificate& authority) const {
  const bool valid =
      X509_CRL_verify(list_.get(), X509_get0_pubkey(authority.certificate_.get())) == 1;
  ERR_clear_error();
  return valid;
}

std::optional<std::time_t> RevocationList::revoked_since(const Certificate& certificate) const {
  X509_REVOKED* entry = nullptr;
  if (X509_CRL_get0_by_cert(list_.get(), &entry, certificate.certificate_.get()) != 1) {
    return std::nullopt;
  }
  return to_time(X509_REVOKED_get0_revocationDate(entry), "date of a revocation");
}

std::vector<Validity> validities_in(const std::string& document) {
  const auto starts = elements(document, "not_before");
  const auto ends = elements(document, "not_after");
  if (starts.size() != ends.size()) {
    throw SecurityFileError("a validity needs both <not_before> and <not_after>");
  }
  std::vector<Validity> validities;
  for (std::size_t k = 0; k < starts.size(); ++k) {
    validities.push_back({to_time(starts[k]), to_time(ends[k])});
  }
  return validities;
}

}  // namespace pipescout::dds
