// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ctime>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/keystore/certificates.hpp"
#include "pipescout/keystore/policy.hpp"

/// A keystore in the layout of SROS 2:
///
///     public/    certificates of the authorities, revocation list
///     private/   keys of the authorities; only the machine that makes enclaves needs them
///     enclaves/  governance, and a folder per enclave with all that its processes need
///
/// Identity and permissions have an authority each. Errors are KeystoreError, which names the file.
namespace pipescout::keystore {

/// Makes authorities and governance. `days`: validity of the authorities, 1 to 36500. Refuses a
/// folder that holds a keystore.
void create_keystore(const std::filesystem::path& keystore, unsigned domain, int days,
                     std::time_t now);

struct EnclaveRequest {
  std::string name;  ///< "/robot_1"; letters, digits and '_' between '/'
  unsigned domain = 0;
  int days = 365;      ///< validity of certificate and permissions; ends with the authority's
  bool renew = false;  ///< new key, certificate and permissions for one that exists
  std::optional<EnclavePolicy> policy;  ///< nothing: every topic
};

/// Makes key, certificate and signed permissions of an enclave. Its files are readable by their
/// owner alone. The certificate that `renew` replaces stays valid until it is revoked.
void create_enclave(const std::filesystem::path& keystore, const EnclaveRequest& request,
                    std::time_t now);

/// Adds the enclave's certificate to the revocation list, which all enclaves link to.
void revoke(const std::filesystem::path& keystore, const std::string& enclave, std::time_t now);

/// What is wrong with keys of the authorities that others than their owner have access to.
[[nodiscard]] std::vector<std::string> exposed_authority_keys(
    const std::filesystem::path& keystore);

/// The names of all enclaves, sorted.
[[nodiscard]] std::vector<std::string> list_enclaves(const std::filesystem::path& keystore);

struct Finding {
  enum class Severity { kOk, kWarning, kError };
  Severity severity = Severity::kOk;
  std::string file;
  std::string text;
  std::optional<std::time_t> not_after;
};

/// Looks at every file of the keystore: there, readable, valid for `warn_days` more, signed by its
/// authority, not revoked, private keys for their owner alone (an error with `strict_keys`, else a
/// warning), one key for both authorities.
[[nodiscard]] std::vector<Finding> check(const std::filesystem::path& keystore, int warn_days,
                                         std::time_t now, bool strict_keys = false);

}  // namespace pipescout::keystore
