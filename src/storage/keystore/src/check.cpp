// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <system_error>

#include "certificates.hpp"
#include "keystore_files.hpp"
#include "pipescout/keystore/keystore.hpp"

namespace pipescout::keystore {
namespace {

using Severity = Finding::Severity;

constexpr std::time_t kSecondsOfOneDay = 24 * 3600;

class Check {
 public:
  Check(const fs::path& keystore, int warn_days, std::time_t now)
      : layout_{keystore}, warn_seconds_(warn_days * kSecondsOfOneDay), now_(now) {}

  std::vector<Finding> run() {
    const auto identity = load_certificate(layout_.shared(kIdentityCa), nullptr);
    const auto permissions = load_certificate(layout_.shared(kPermissionsCa), nullptr);
    if (identity && permissions && X509_cmp(identity.get(), permissions.get()) == 0) {
      add(Severity::kWarning, layout_.shared(kPermissionsCa),
          "is the authority of the identities too: who can make one can make the other");
    }
    std::error_code ignored;
    for (const char* const key : {kIdentityKey, kPermissionsKey}) {
      // Only the machine that makes enclaves has them.
      if (fs::exists(layout_.secret(key), ignored)) {
        secret(layout_.secret(key));
      }
    }
    RevocationList revocations;
    if (fs::exists(layout_.shared(kRevocations), ignored)) {
      revocations = attempt(layout_.shared(kRevocations),
                            [&](const fs::path& file) { return load(file, read_revocation_list); });
      if (revocations && identity &&
          X509_CRL_verify(revocations.get(), X509_get0_pubkey(identity.get())) != 1) {
        add(Severity::kError, layout_.shared(kRevocations),
            "not signed by the authority of the identities");
      }
    }
    document(layout_.governance(), permissions.get());
    for (const auto& name : list_enclaves(layout_.folder)) {
      enclave(layout_.enclave(name), identity.get(), permissions.get(), revocations.get());
    }
    return std::move(findings_);
  }

 private:
  void add(Severity severity, const fs::path& file, std::string text,
           std::optional<std::time_t> not_after = std::nullopt) {
    findings_.push_back({severity, file.string(), std::move(text), not_after});
  }

  template <class Read>
  auto attempt(const fs::path& file, const Read& read) -> decltype(read(file)) {
    try {
      return read(file);
    } catch (const KeystoreError& error) {
      std::string what = error.what();
      const std::string prefix = file.string() + ": ";
      add(Severity::kError, file, what.starts_with(prefix) ? what.substr(prefix.size()) : what);
      return {};
    }
  }

  void secret(const fs::path& file) {
    attempt(file, [&](const fs::path& key) {
      check_secret(key);
      static_cast<void>(load(key, read_key));
      add(Severity::kOk, key, "readable by its owner alone");
      return true;
    });
  }

  void validity(const fs::path& file, const Validity& validity) {
    if (now_ < validity.not_before) {
      add(Severity::kError, file, "not valid before " + date_text(validity.not_before),
          validity.not_after);
    } else if (now_ > validity.not_after) {
      add(Severity::kError, file, "expired on " + date_text(validity.not_after),
          validity.not_after);
    } else {
      const auto left = validity.not_after - now_;
      add(left < warn_seconds_ ? Severity::kWarning : Severity::kOk, file,
          "valid for " + std::to_string(left / kSecondsOfOneDay) + " days, until " +
              date_text(validity.not_after),
          validity.not_after);
    }
  }

  Certificate load_certificate(const fs::path& file, X509* authority) {
    auto certificate =
        attempt(file, [](const fs::path& path) { return load(path, read_certificate); });
    if (certificate == nullptr) {
      return certificate;
    }
    if (authority != nullptr && !is_signed_by(*certificate, *authority)) {
      add(Severity::kError, file, "not signed by the authority of the identities");
    }
    validity(file, validity_of(*certificate));
    return certificate;
  }

  void document(const fs::path& file, X509* authority) {
    const auto text = attempt(file, [](const fs::path& path) { return content_of(path); });
    if (!text.empty() && authority != nullptr) {
      const bool good = verified(text, *authority).has_value();
      add(good ? Severity::kOk : Severity::kError, file,
          good ? "signed by the authority of the permissions"
               : "not signed by the authority of the permissions, or changed since");
    }
  }

  void enclave(const fs::path& folder, X509* identity, X509* permissions, X509_CRL* revocations) {
    const auto certificate = load_certificate(folder / kCertificate, identity);
    if (certificate && revocations != nullptr) {
      if (const auto since = revoked_since(*revocations, *certificate)) {
        add(Severity::kWarning, folder / kCertificate, "revoked on " + date_text(*since));
      }
    }
    secret(folder / kPrivateKey);
    document(folder / kPermissions, permissions);
    for (const char* const name : {kIdentityCa, kPermissionsCa, kGovernance}) {
      attempt(folder / name, [](const fs::path& path) { return content_of(path); });
    }
  }

  const Layout layout_;
  const std::time_t warn_seconds_;
  const std::time_t now_;
  std::vector<Finding> findings_;
};

}  // namespace

std::string date_text(std::time_t time) {
  std::tm parts{};
  gmtime_r(&time, &parts);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M UTC", &parts)};
}

std::string content_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    throw KeystoreError(file.string() + ": " + std::generic_category().message(errno));
  }
  std::string content(std::istreambuf_iterator<char>(stream), {});
  if (content.empty()) {
    throw KeystoreError(file.string() + ": is empty");
  }
  return content;
}

void check_secret(const fs::path& file) {
  struct stat status {};
  if (stat(file.c_str(), &status) != 0) {
    throw KeystoreError(file.string() + ": " + std::generic_category().message(errno));
  }
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    throw KeystoreError(file.string() +
                        ": others than its owner have access to the private key; chmod 600 it");
  }
}

std::vector<Finding> check(const fs::path& keystore, int warn_days, std::time_t now) {
  return Check(keystore, warn_days, now).run();
}

}  // namespace pipescout::keystore
