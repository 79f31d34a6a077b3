// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ctime>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

// Of OpenSSL, by their tags.
struct x509_st;
struct X509_crl_st;

/// What DDS Security's files say, from their texts. Errors are KeystoreError without a file.
namespace pipescout::keystore {

class KeystoreError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Validity {
  std::time_t not_before = 0;
  std::time_t not_after = 0;
};

/// "2027-11-26 12:00:00 UTC".
[[nodiscard]] std::string date_text(std::time_t time);

/// An X.509 certificate. Copies share it.
class Certificate {
 public:
  /// From PEM.
  explicit Certificate(const std::string& pem);
  /// Takes it over; not null.
  explicit Certificate(x509_st* certificate);

  [[nodiscard]] Validity validity() const;
  [[nodiscard]] bool is_signed_by(const Certificate& authority) const;
  [[nodiscard]] bool is_same_as(const Certificate& other) const;
  /// `key`: a private key, PEM.
  [[nodiscard]] bool fits_key(const std::string& key) const;
  /// The document in a message that this authority signed (S/MIME); nothing when it did not.
  [[nodiscard]] std::optional<std::string> verified(const std::string& message) const;

  [[nodiscard]] x509_st& handle() const { return *certificate_; }

 private:
  std::shared_ptr<x509_st> certificate_;
};

/// An X.509 certificate revocation list. Copies share it.
class RevocationList {
 public:
  /// From PEM.
  explicit RevocationList(const std::string& pem);
  /// Takes it over; not null.
  explicit RevocationList(X509_crl_st* list);

  [[nodiscard]] Validity validity() const;
  [[nodiscard]] bool is_signed_by(const Certificate& authority) const;
  [[nodiscard]] std::optional<std::time_t> revoked_since(const Certificate& certificate) const;

  [[nodiscard]] X509_crl_st& handle() const { return *list_; }

 private:
  std::shared_ptr<X509_crl_st> list_;
};

/// The validities of the grants in a permissions document (DDS Security 1.1, 9.4.1.3); none for a
/// governance. The error names a date that is none.
[[nodiscard]] std::vector<Validity> validities_in(const std::string& document);

/// DDS domains `first` to `last`, both included.
struct DomainRange {
  unsigned first = 0;
  unsigned last = 0;
  bool operator==(const DomainRange&) const = default;
};

/// The domains for which a permissions document allows something, or for which a governance has
/// rules (9.4.1.3.2.3.1.1, 9.4.1.2.5), in the order of the document. The error names an element
/// that is no domain.
[[nodiscard]] std::vector<DomainRange> domains_in(const std::string& document);

/// "0, 5 to 7"; "none".
[[nodiscard]] std::string to_string(const std::vector<DomainRange>& domains);

/// Every partition, the default one included, whose name is empty.
inline constexpr const char* kAnyPartition = "*";

/// Whether a permissions document grants more than the default partition (9.4.1.3.2.3.1.3): with
/// `kAnyPartition` for its topics.
[[nodiscard]] bool grants_any_partition(const std::string& document);

}  // namespace pipescout::keystore
