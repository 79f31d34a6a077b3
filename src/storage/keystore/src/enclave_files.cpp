// SPDX-License-Identifier: Apache-2.0
#include "pipescout/keystore/enclave_files.hpp"

#include <sys/stat.h>

#include <cerrno>
#include <fstream>
#include <iterator>
#include <system_error>

namespace pipescout::keystore {

namespace fs = std::filesystem;

std::string content_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    throw KeystoreError(file.string() + ": " + std::generic_category().message(errno));
  }
  std::string content;
  try {
    content.assign(std::istreambuf_iterator<char>(stream), {});
  } catch (const std::ios_base::failure&) {  // such as a folder
    throw KeystoreError(file.string() +
                        ": cannot be read: " + std::generic_category().message(errno));
  }
  if (content.empty()) {
    throw KeystoreError(file.string() + ": is empty");
  }
  return content;
}

std::optional<std::string> exposure_of(const fs::path& key) {
  struct stat status {};
  if (stat(key.c_str(), &status) != 0) {
    throw KeystoreError(key.string() + ": " + std::generic_category().message(errno));
  }
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) == 0) {
    return std::nullopt;
  }
  return key.string() + ": others than its owner have access to the private key; chmod 600 it";
}

}  // namespace pipescout::keystore
