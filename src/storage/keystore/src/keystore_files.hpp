// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "pipescout/keystore/enclave_files.hpp"

/// Where the files of a keystore stand, and how they are read.
namespace pipescout::keystore {

namespace fs = std::filesystem;

inline constexpr const char* kIdentityKey = "identity_ca.key.pem";
inline constexpr const char* kPermissionsKey = "permissions_ca.key.pem";
inline constexpr const char* kRevocations = "identity_ca.crl.pem";

struct Layout {
  fs::path folder;

  [[nodiscard]] fs::path shared(const char* name) const { return folder / "public" / name; }
  [[nodiscard]] fs::path secret(const char* name) const { return folder / "private" / name; }
  [[nodiscard]] fs::path enclaves() const { return folder / "enclaves"; }
  [[nodiscard]] fs::path governance() const { return enclaves() / kGovernance; }
  [[nodiscard]] fs::path enclave(const std::string& name) const {
    return name == "/" ? enclaves() : enclaves() / name.substr(1);
  }
};

/// What a function reads from the content; its errors get the name of the file.
template <class Read>
[[nodiscard]] auto load(const fs::path& file, const Read& read) {
  try {
    return read(content_of(file));
  } catch (const KeystoreError& error) {
    const std::string what = error.what();
    throw KeystoreError(what.starts_with(file.string()) ? what : file.string() + ": " + what);
  }
}

/// The same of what is made from a text.
template <class T>
[[nodiscard]] T load(const fs::path& file) {
  return load(file, [](const std::string& text) { return T(text); });
}

}  // namespace pipescout::keystore
