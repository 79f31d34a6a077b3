// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "openssl_handles.hpp"
#include "pipescout/keystore/certificates.hpp"

/// Makes keys, certificates, signatures and revocations. Errors are KeystoreError without a file.
namespace pipescout::keystore {

using Key = OpenSsl<EVP_PKEY>;

/// On the curve P-256, as SROS 2 has them.
[[nodiscard]] Key make_key();
/// From PEM.
[[nodiscard]] Key read_key(const std::string& pem);
/// Signed by itself.
[[nodiscard]] Certificate make_authority(EVP_PKEY& key, const std::string& name,
                                         const Validity& validity);
[[nodiscard]] Certificate make_certificate(EVP_PKEY& key, const std::string& name,
                                           const Validity& validity, const Certificate& authority,
                                           EVP_PKEY& authority_key);
/// S/MIME of a readable text.
[[nodiscard]] std::string sign(const std::string& document, const Certificate& authority,
                               EVP_PKEY& authority_key);

[[nodiscard]] RevocationList make_revocation_list(const Certificate& authority,
                                                  EVP_PKEY& authority_key, std::time_t now);
/// False when it is in the list already.
bool add_revoked(const RevocationList& list, const Certificate& certificate,
                 const Certificate& authority, EVP_PKEY& authority_key, std::time_t now);

[[nodiscard]] std::string to_pem(EVP_PKEY& key);
[[nodiscard]] std::string to_pem(const Certificate& certificate);
[[nodiscard]] std::string to_pem(const RevocationList& list);

}  // namespace pipescout::keystore
