// SPDX-License-Identifier: Apache-2.0
#include "security.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "pipescout/keystore/certificates.hpp"
#include "pipescout/keystore/enclave_files.hpp"

namespace pipescout::dds {
namespace {

namespace fs = std::filesystem;

using keystore::Certificate;
using keystore::content_of;
using keystore::date_text;
using keystore::kCertificate;
using keystore::kEnclaveRevocations;
using keystore::KeystoreError;
using keystore::kGovernance;
using keystore::kIdentityCa;
using keystore::kPermissions;
using keystore::kPermissionsCa;
using keystore::kPrivateKey;
using keystore::RevocationList;
using keystore::Validity;

constexpr std::array kRequired{kIdentityCa,    kCertificate, kPrivateKey,
                               kPermissionsCa, kGovernance,  kPermissions};

// From when on the end of a validity is warned of.
constexpr std::time_t kWarningSeconds = std::time_t{30} * 24 * 3600;

constexpr auto kTimeBetweenLooks = std::chrono::seconds(2);

// What a message of the handshake (DDS Security 1.1, 9.3.2.5) holds besides certificate and
// permissions: the participant's discovery data, keys, hashes, a signature. Less than half of this.
constexpr std::size_t kHandshakeBesidesFiles = 4096;
constexpr std::size_t kMostHandshakeBytes = 65'000;  // of a datagram

/// Empty when it cannot be read.
std::string read(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  try {
    return {std::istreambuf_iterator<char>(stream), {}};
  } catch (const std::ios_base::failure&) {  // such as a folder
    return {};
  }
}

[[noreturn]] void refuse(const fs::path& file, const std::string& why) {
  throw TransportError("DDS Security: " + file.string() + ": " + why);
}

/// Why the enclave cannot be used at all; empty when all files are there.
std::string missing(const SecurityOptions& security, const std::string& enclave,
                    const fs::path& folder) {
  if (security.keystore.empty()) {
    return "ROS_SECURITY_KEYSTORE is not set";
  }
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) {
    return "no enclave '" + enclave + "': there is no folder " + folder.string();
  }
  for (const char* const name : kRequired) {
    if (!fs::exists(folder / name, ignored)) {
      return (folder / name).string() + ": there is no such file";
    }
  }
  return {};
}

void check_validity(const fs::path& file, const Validity& validity, std::time_t now,
                    Warnings& warnings) {
  if (now < validity.not_before) {
    refuse(file, "not valid before " + date_text(validity.not_before) + "; it is " +
                     date_text(now) + " now");
  }
  if (now > validity.not_after) {
    refuse(file,
           "expired on " + date_text(validity.not_after) + "; it is " + date_text(now) + " now");
  }
  if (now > validity.not_after - kWarningSeconds) {
    warnings.add("DDS Security: " + file.string() + " expires on " + date_text(validity.not_after));
  }
}

template <class T>
T load(const fs::path& file) {
  const std::string text = content_of(file);
  try {
    return T(text);
  } catch (const KeystoreError& error) {
    refuse(file, error.what());
  }
}

/// Of a signed document. Fast DDS says nothing of the domain.
void check_domain(const fs::path& file, const std::string& document, std::uint32_t domain) {
  const auto domains = keystore::domains_in(document);
  if (std::none_of(domains.begin(), domains.end(), [&](const keystore::DomainRange& range) {
        return range.first <= domain && domain <= range.last;
      })) {
    refuse(file, "is for domain " + keystore::to_string(domains) +
                     ", and this process joins domain " + std::to_string(domain) +
                     " (ROS_DOMAIN_ID)");
  }
}

/// Whether the permissions grant every partition.
bool check_documents(const fs::path& folder, const Certificate& permissions_ca,
                     std::uint32_t domain, std::time_t now, Warnings& warnings) {
  bool any_partition = false;
  for (const char* const name : {kGovernance, kPermissions}) {
    const auto document = permissions_ca.verified(content_of(folder / name));
    if (!document) {
      refuse(folder / name, std::string("not signed by the authority of ") + kPermissionsCa +
                                ", or changed since");
    }
    try {
      for (const Validity& validity : keystore::validities_in(*document)) {
        check_validity(folder / name, validity, now, warnings);
      }
      check_domain(folder / name, *document, domain);
    } catch (const KeystoreError& error) {
      refuse(folder / name, error.what());
    }
    any_partition |= keystore::grants_any_partition(*document);  // a governance has none
  }
  return any_partition;
}

void check_revocations(const fs::path& folder, const Certificate& identity_ca,
                       const Certificate& own, std::time_t now, Warnings& warnings) {
  const fs::path file = folder / kEnclaveRevocations;
  std::error_code ignored;
  if (!fs::exists(file, ignored)) {
    return;
  }
  const auto revocations = load<RevocationList>(file);
  if (!revocations.is_signed_by(identity_ca)) {
    refuse(file, std::string("not signed by the authority of ") + kIdentityCa);
  }
  check_validity(file, revocations.validity(), now, warnings);
  if (const auto since = revocations.revoked_since(own)) {
    refuse(folder / kCertificate,
           "was revoked on " + date_text(*since) + " (" + kEnclaveRevocations + ")");
  }
}

/// Fast DDS says of most of this only that the participant could not be created. Whether the
/// permissions grant every partition.
bool check_files(const fs::path& folder, const DdsOptions& options, Warnings& warnings) {
  const std::time_t now = std::time(nullptr);
  if (const auto exposure = keystore::exposure_of(folder / kPrivateKey)) {
    if (options.security.strict_keys) {
      throw KeystoreError(*exposure + " (refused, since PIPESCOUT_STRICT_KEYS is true)");
    }
    warnings.add("DDS Security: " + *exposure);
  }
  const auto identity_ca = load<Certificate>(folder / kIdentityCa);
  const auto permissions_ca = load<Certificate>(folder / kPermissionsCa);
  const auto own = load<Certificate>(folder / kCertificate);
  check_validity(folder / kIdentityCa, identity_ca.validity(), now, warnings);
  check_validity(folder / kPermissionsCa, permissions_ca.validity(), now, warnings);
  check_validity(folder / kCertificate, own.validity(), now, warnings);
  if (!own.is_signed_by(identity_ca)) {
    refuse(folder / kCertificate, std::string("not signed by the authority of ") + kIdentityCa);
  }
  if (!own.fits_key(content_of(folder / kPrivateKey))) {
    refuse(folder / kPrivateKey, std::string("is no private key of ") + kCertificate);
  }
  check_revocations(folder, identity_ca, own, now, warnings);
  return check_documents(folder, permissions_ca, options.domain_id, now, warnings);
}

}  // namespace

const std::string& effective_enclave(const DdsOptions& options) {
  return options.security.enclave_override.empty() ? options.enclave
                                                   : options.security.enclave_override;
}

AppliedSecurity apply_security(const DdsOptions& options, Warnings& warnings,
                               eprosima::fastdds::dds::DomainParticipantQos& qos) {
  const SecurityOptions& security = options.security;
  if (!security.enabled) {
    return {};
  }
  const std::string& enclave = effective_enclave(options);
  if (!enclave.starts_with('/')) {
    throw TransportError("enclave '" + enclave + "': must begin with '/'");
  }
  const fs::path folder = (security.keystore / "enclaves" / enclave.substr(1)).lexically_normal();
  if (const auto why = missing(security, enclave, folder); !why.empty()) {
    if (security.enforce) {
      throw TransportError("DDS Security: " + why);
    }
    warnings.add("DDS Security: " + why +
                 ": runs WITHOUT security (ROS_SECURITY_STRATEGY is not "
                 "'Enforce')");
    return {};
  }
  AppliedSecurity applied;
  try {
    applied.may_use_any_partition = check_files(folder, options, warnings);
    applied.handshake_bytes = static_cast<std::uint32_t>(std::min(
        kMostHandshakeBytes, kHandshakeBesidesFiles + content_of(folder / kCertificate).size() +
                                 content_of(folder / kPermissions).size()));
  } catch (const KeystoreError& error) {
    throw TransportError(std::string("DDS Security: ") + error.what());
  }
  if (options.exported_topics && !applied.may_use_any_partition) {
    refuse(folder / kPermissions,
           "grants the default partition alone, and topics that are not exported need another one: "
           "'pipescout security create-enclave --renew' grants all, or leave out 'export'");
  }
  if (!options.discovery_servers.empty()) {
    throw TransportError(
        "DDS Security: participants of Fast DDS " + fast_dds_version() +
        " do not find each other through a discovery server when they are secured: unset "
        "ROS_DISCOVERY_SERVER; without multicast name peers in ROS_STATIC_PEERS");
  }
  auto& properties = qos.properties().properties();
  const auto set = [&](const std::string& name, const std::string& value) {
    properties.emplace_back("dds.sec." + name, value);
  };
  const auto set_file = [&](const std::string& name, const char* file) {
    set(name, "file://" + fs::absolute(folder / file).string());
  };
  set("auth.plugin", "builtin.PKI-DH");
  set_file("auth.builtin.PKI-DH.identity_ca", kIdentityCa);
  set_file("auth.builtin.PKI-DH.identity_certificate", kCertificate);
  set_file("auth.builtin.PKI-DH.private_key", kPrivateKey);
  set("crypto.plugin", "builtin.AES-GCM-GMAC");
  set("access.plugin", "builtin.Access-Permissions");
  set_file("access.builtin.Access-Permissions.permissions_ca", kPermissionsCa);
  set_file("access.builtin.Access-Permissions.governance", kGovernance);
  set_file("access.builtin.Access-Permissions.permissions", kPermissions);
  std::error_code ignored;
  if (fs::exists(folder / kEnclaveRevocations, ignored)) {
    set_file("auth.builtin.PKI-DH.identity_crl", kEnclaveRevocations);
    applied.revocations = folder / kEnclaveRevocations;
  }
  return applied;
}

RevocationWatch::RevocationWatch(EventThread& events, std::filesystem::path file,
                                 std::function<void()> changed)
    : events_(events),
      file_(std::move(file)),
      changed_(std::move(changed)),
      content_(file_.empty() ? std::string() : read(file_)) {
  events_.admit(this);
  if (!file_.empty()) {
    look_later();
  }
}

RevocationWatch::~RevocationWatch() {
  events_.dismiss(this);
}

void RevocationWatch::look_later() {
  events_.post_after(this, kTimeBetweenLooks, [this] {
    if (read(file_) == content_) {
      look_later();
    } else {
      changed_();
    }
  });
}

}  // namespace pipescout::dds
