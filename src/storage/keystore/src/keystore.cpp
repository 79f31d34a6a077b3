// SPDX-License-Identifier: Apache-2.0
#include "pipescout/keystore/keystore.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <system_error>
#include <utility>

#include "keystore_files.hpp"
#include "pipescout/files/whole_file.hpp"
#include "signing.hpp"

namespace pipescout::keystore {
namespace {

constexpr int kMaxDays = 36500;
constexpr std::time_t kSecondsOfDay = 24 * 3600;

// A robot whose clock is behind can use what was made just now.
constexpr std::time_t kClockMargin = 3600;

void check_days(int days) {
  if (days < 1 || days > kMaxDays) {
    throw KeystoreError("days " + std::to_string(days) + ": must be in 1.." +
                        std::to_string(kMaxDays));
  }
}

constexpr unsigned kHighestDomain = 232;

void check_domain(unsigned domain) {
  if (domain > kHighestDomain) {
    throw KeystoreError("domain " + std::to_string(domain) + ": must be in 0.." +
                        std::to_string(kHighestDomain));
  }
}

void check_name(const std::string& name) {
  const auto refuse = [&](const std::string& why) {
    throw KeystoreError("enclave '" + name + "': " + why);
  };
  // RFC 5280 bounds the common name of a certificate, which is this name.
  constexpr std::size_t kLongest = 64;
  if (!name.starts_with('/')) {
    refuse("must begin with '/'");
  }
  if (name.size() > kLongest) {
    refuse("must have at most " + std::to_string(kLongest) + " characters");
  }
  char before = '\0';
  for (const char c : name) {
    const bool letter = std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
    const bool digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
    if (!letter && !digit && c != '/') {
      refuse("may hold letters, digits, '_' and '/'");
    }
    if (before == '/' && !letter) {
      refuse("each part must begin with a letter or '_'");
    }
    before = c;
  }
  if (name.size() > 1 && name.ends_with('/')) {
    refuse("must not end with '/'");
  }
}

void make_folder(const fs::path& folder, fs::perms permissions) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) {
    fs::permissions(folder, permissions, error);
  }
  if (error) {
    throw KeystoreError(folder.string() + ": cannot be made: " + error.message());
  }
}

void write(const fs::path& file, const std::string& content) {
  try {
    replace_file(file, content);
  } catch (const std::system_error& error) {
    throw KeystoreError(error.what());
  }
}

/// Nobody else can read it at any moment.
void write_secret(const fs::path& file, const std::string& content) {
  const mode_t before = umask(S_IRWXG | S_IRWXO);
  try {
    write(file, content);
  } catch (...) {
    umask(before);
    throw;
  }
  umask(before);
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
}

void link(const fs::path& target, const fs::path& file) {
  std::error_code error;
  fs::remove(file, error);
  fs::create_symlink(fs::relative(target, file.parent_path()), file, error);
  if (error) {
    throw KeystoreError(file.string() + ": cannot be made: " + error.message());
  }
}

struct Authority {
  Certificate certificate;
  Key key;
};

Authority load_authority(const Layout& layout, const char* certificate, const char* key) {
  return {load<Certificate>(layout.shared(certificate)), load(layout.secret(key), read_key)};
}

void make_authority_files(const Layout& layout, const char* certificate_file, const char* key_file,
                          const std::string& name, const Validity& validity) {
  const Key key = make_key();
  write_secret(layout.secret(key_file), to_pem(*key));
  write(layout.shared(certificate_file), to_pem(make_authority(*key, name, validity)));
}

void require_keystore(const Layout& layout) {
  std::error_code ignored;
  if (!fs::exists(layout.shared(kIdentityCa), ignored)) {
    throw KeystoreError(layout.folder.string() + ": is no keystore: there is no " +
                        layout.shared(kIdentityCa).string());
  }
}

void link_shared_files(const Layout& layout, const fs::path& folder) {
  link(layout.shared(kIdentityCa), folder / kIdentityCa);
  link(layout.shared(kPermissionsCa), folder / kPermissionsCa);
  if (folder != layout.enclaves()) {  // that of the enclave "/", which holds the governance itself
    link(layout.governance(), folder / kGovernance);
  }
  std::error_code ignored;
  if (fs::exists(layout.shared(kRevocations), ignored)) {
    link(layout.shared(kRevocations), folder / kEnclaveRevocations);
  }
}

}  // namespace

void create_keystore(const fs::path& keystore, unsigned domain, int days, std::time_t now) {
  check_days(days);
  check_domain(domain);
  const Layout layout{keystore};
  std::error_code ignored;
  if (fs::exists(layout.shared(kIdentityCa), ignored) || fs::exists(layout.enclaves(), ignored)) {
    throw KeystoreError(keystore.string() + ": holds a keystore already");
  }
  const auto everyone_reads = fs::perms::owner_all | fs::perms::group_read | fs::perms::group_exec |
                              fs::perms::others_read | fs::perms::others_exec;
  make_folder(keystore / "public", everyone_reads);
  make_folder(layout.enclaves(), everyone_reads);
  make_folder(keystore / "private", fs::perms::owner_all);
  const Validity validity{now - kClockMargin, now + days * kSecondsOfDay};
  make_authority_files(layout, kIdentityCa, kIdentityKey, "Pipescout identities", validity);
  make_authority_files(layout, kPermissionsCa, kPermissionsKey, "Pipescout permissions", validity);
  const auto identity = load_authority(layout, kIdentityCa, kIdentityKey);
  const auto list = make_revocation_list(identity.certificate, *identity.key, now);
  write(layout.shared(kRevocations), to_pem(list));
  const auto permissions = load_authority(layout, kPermissionsCa, kPermissionsKey);
  const std::string governance = to_governance_xml(domain);
  write(layout.enclaves() / "governance.xml", governance);
  write(layout.governance(), sign(governance, permissions.certificate, *permissions.key));
}

void create_enclave(const fs::path& keystore, const EnclaveRequest& request, std::time_t now) {
  check_days(request.days);
  check_domain(request.domain);
  check_name(request.name);
  const Layout layout{keystore};
  require_keystore(layout);
  const fs::path folder = layout.enclave(request.name);
  std::error_code ignored;
  if (fs::exists(folder / kCertificate, ignored) != request.renew) {
    throw KeystoreError(request.renew ? "enclave '" + request.name + "': there is none to renew"
                                      : "enclave '" + request.name +
                                            "': exists already; renew it, or revoke it first");
  }
  const auto identity = load_authority(layout, kIdentityCa, kIdentityKey);
  const auto permissions = load_authority(layout, kPermissionsCa, kPermissionsKey);
  const Validity of_identity = identity.certificate.validity();
  const Validity of_permissions = permissions.certificate.validity();
  const auto latest = std::min(of_identity.not_after, of_permissions.not_after);
  if (now > latest) {
    throw KeystoreError(keystore.string() + ": an authority expired on " + date_text(latest));
  }
  const Validity validity{now - kClockMargin, std::min(now + request.days * kSecondsOfDay, latest)};
  if (folder != layout.enclaves()) {
    make_folder(folder, fs::perms::owner_all);
  }
  const Key key = make_key();
  const auto certificate =
      make_certificate(*key, request.name, validity, identity.certificate, *identity.key);
  const std::string grant =
      to_permissions_xml(request.name, request.policy ? &*request.policy : nullptr, request.domain,
                         validity.not_before, validity.not_after);
  write_secret(folder / kPrivateKey, to_pem(*key));
  write(folder / kCertificate, to_pem(certificate));
  write(folder / "permissions.xml", grant);
  write(folder / kPermissions, sign(grant, permissions.certificate, *permissions.key));
  link_shared_files(layout, folder);
}

void revoke(const fs::path& keystore, const std::string& enclave, std::time_t now) {
  check_name(enclave);
  const Layout layout{keystore};
  require_keystore(layout);
  const auto identity = load_authority(layout, kIdentityCa, kIdentityKey);
  const auto certificate = load<Certificate>(layout.enclave(enclave) / kCertificate);
  std::error_code ignored;
  const auto list = fs::exists(layout.shared(kRevocations), ignored)
                        ? load<RevocationList>(layout.shared(kRevocations))
                        : make_revocation_list(identity.certificate, *identity.key, now);
  if (!add_revoked(list, certificate, identity.certificate, *identity.key, now)) {
    throw KeystoreError("enclave '" + enclave + "': was revoked on " +
                        date_text(*list.revoked_since(certificate)));
  }
  write(layout.shared(kRevocations), to_pem(list));
  for (const auto& name : list_enclaves(keystore)) {
    link_shared_files(layout, layout.enclave(name));
  }
}

std::vector<std::string> exposed_authority_keys(const fs::path& keystore) {
  const Layout layout{keystore};
  std::vector<std::string> exposed;
  std::error_code ignored;
  for (const char* const key : {kIdentityKey, kPermissionsKey}) {
    // Only the machine that makes enclaves has them.
    if (!fs::exists(layout.secret(key), ignored)) {
      continue;
    }
    if (auto exposure = exposure_of(layout.secret(key))) {
      exposed.push_back(*std::move(exposure));
    }
  }
  return exposed;
}

std::vector<std::string> list_enclaves(const fs::path& keystore) {
  const Layout layout{keystore};
  require_keystore(layout);
  std::vector<std::string> names;
  std::error_code error;
  for (fs::recursive_directory_iterator it(layout.enclaves(), error), end; !error && it != end;
       it.increment(error)) {
    if (it->path().filename() == kCertificate) {
      const auto relative = it->path().parent_path().lexically_relative(layout.enclaves());
      names.push_back(relative == "." ? "/" : "/" + relative.string());
    }
  }
  if (error) {
    throw KeystoreError(layout.enclaves().string() + ": cannot be read: " + error.message());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace pipescout::keystore
