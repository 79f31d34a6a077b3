// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <system_error>
#include <utility>

#include "keystore_files.hpp"
#include "pipescout/keystore/keystore.hpp"
#include "signing.hpp"

namespace pipescout::keystore {
namespace {

using Severity = Finding::Severity;

constexpr std::time_t kSecondsOfOneDay = 24 * 3600;

template <class T>
std::optional<T> load_optional(const fs::path& file) {
  return load<T>(file);
}

class Check {
 public:
  Check(const fs::path& keystore, int warn_days, std::time_t now, bool strict_keys)
      : layout_{keystore},
        warn_seconds_(warn_days * kSecondsOfOneDay),
        now_(now),
        strict_keys_(strict_keys) {}

  std::vector<Finding> run() {
    identity_ = load_certificate(layout_.shared(kIdentityCa));
    permissions_ = load_certificate(layout_.shared(kPermissionsCa));
    if (identity_ && permissions_ && identity_->is_same_as(*permissions_)) {
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
    if (fs::exists(layout_.shared(kRevocations), ignored)) {
      revocations_ = attempt(layout_.shared(kRevocations), load_optional<RevocationList>);
      if (revocations_ && identity_ && !revocations_->is_signed_by(*identity_)) {
        add(Severity::kError, layout_.shared(kRevocations),
            "not signed by the authority of the identities");
      }
    }
    document(layout_.governance());
    for (const auto& name : list_enclaves(layout_.folder)) {
      enclave(layout_.enclave(name));
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
      static_cast<void>(load(key, read_key));
      if (const auto exposure = exposure_of(key)) {
        add(strict_keys_ ? Severity::kError : Severity::kWarning, key,
            exposure->substr(key.string().size() + 2));
      } else {
        add(Severity::kOk, key, "readable by its owner alone");
      }
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

  std::optional<Certificate> load_certificate(const fs::path& file) {
    auto certificate = attempt(file, load_optional<Certificate>);
    if (certificate) {
      validity(file, certificate->validity());
    }
    return certificate;
  }

  void document(const fs::path& file) {
    const auto text = attempt(file, [](const fs::path& path) { return content_of(path); });
    if (!text.empty() && permissions_) {
      const bool good = permissions_->verified(text).has_value();
      add(good ? Severity::kOk : Severity::kError, file,
          good ? "signed by the authority of the permissions"
               : "not signed by the authority of the permissions, or changed since");
    }
  }

  void enclave(const fs::path& folder) {
    const auto certificate = load_certificate(folder / kCertificate);
    if (certificate && identity_ && !certificate->is_signed_by(*identity_)) {
      add(Severity::kError, folder / kCertificate, "not signed by the authority of the identities");
    }
    if (certificate && revocations_) {
      if (const auto since = revocations_->revoked_since(*certificate)) {
        add(Severity::kWarning, folder / kCertificate, "revoked on " + date_text(*since));
      }
    }
    secret(folder / kPrivateKey);
    document(folder / kPermissions);
    for (const char* const name : {kIdentityCa, kPermissionsCa, kGovernance}) {
      attempt(folder / name, [](const fs::path& path) { return content_of(path); });
    }
  }

  const Layout layout_;
  const std::time_t warn_seconds_;
  const std::time_t now_;
  const bool strict_keys_;
  std::optional<Certificate> identity_;  // of the authorities
  std::optional<Certificate> permissions_;
  std::optional<RevocationList> revocations_;
  std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> check(const fs::path& keystore, int warn_days, std::time_t now,
                           bool strict_keys) {
  return Check(keystore, warn_days, now, strict_keys).run();
}

}  // namespace pipescout::keystore
