// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "pipescout/keystore/certificates.hpp"

/// The files in the folder of an enclave, as SROS 2 and rmw_dds_common (Humble) name them.
namespace pipescout::keystore {

inline constexpr const char* kIdentityCa = "identity_ca.cert.pem";
inline constexpr const char* kPermissionsCa = "permissions_ca.cert.pem";
inline constexpr const char* kCertificate = "cert.pem";
inline constexpr const char* kPrivateKey = "key.pem";
inline constexpr const char* kGovernance = "governance.p7s";
inline constexpr const char* kPermissions = "permissions.p7s";
inline constexpr const char* kEnclaveRevocations = "crl.pem";  ///< may be missing

/// Throws KeystoreError, which names the file, when it cannot be read or is empty.
[[nodiscard]] std::string content_of(const std::filesystem::path& file);

/// What is wrong with a private key that others than its owner have access to, with the name of the
/// file: SROS 2 makes them so. Nothing when only its owner has. Throws KeystoreError, which names
/// the file, when there is none.
[[nodiscard]] std::optional<std::string> exposure_of(const std::filesystem::path& key);

}  // namespace pipescout::keystore
