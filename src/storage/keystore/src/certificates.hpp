// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "openssl_handles.hpp"
#include "pipescout/keystore/keystore.hpp"

/// Keys, certificates, signatures and revocations as PEM texts. Errors are KeystoreError without a
/// file.
namespace pipescout::keystore {

using Key = OpenSsl<EVP_PKEY>;
using Certificate = OpenSsl<X509>;
using RevocationList = OpenSsl<X509_CRL>;

/// On the curve P-256, as SROS 2 has them.
[[nodiscard]] Key make_key();
/// Signed by itself.
[[nodiscard]] Certificate make_authority(EVP_PKEY& key, const std::string& name,
                                         const Validity& validity);
[[nodiscard]] Certificate make_certificate(EVP_PKEY& key, const std::string& name,
                                           const Validity& validity, X509& authority,
                                           EVP_PKEY& authority_key);
/// S/MIME of a readable text.
[[nodiscard]] std::string sign(const std::string& document, X509& authority,
                               EVP_PKEY& authority_key);
/// The document, when this authority signed it.
[[nodiscard]] std::optional<std::string> verified(const std::string& message, X509& authority);

[[nodiscard]] RevocationList make_revocation_list(X509& authority, EVP_PKEY& authority_key,
                                                  std::time_t now);
/// False when it is in the list already.
bool add_revoked(X509_CRL& list, X509& certificate, X509& authority, EVP_PKEY& authority_key,
                 std::time_t now);
[[nodiscard]] std::optional<std::time_t> revoked_since(X509_CRL& list, X509& certificate);

[[nodiscard]] Validity validity_of(const X509& certificate);
[[nodiscard]] bool is_signed_by(X509& certificate, X509& authority);

[[nodiscard]] std::string to_pem(EVP_PKEY& key);
[[nodiscard]] std::string to_pem(X509& certificate);
[[nodiscard]] std::string to_pem(X509_CRL& list);
[[nodiscard]] Key read_key(const std::string& pem);
[[nodiscard]] Certificate read_certificate(const std::string& pem);
[[nodiscard]] RevocationList read_revocation_list(const std::string& pem);

}  // namespace pipescout::keystore
