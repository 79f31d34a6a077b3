// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

/// An installation prefix in a temporary folder, with an index of component classes.
class TemporaryPrefix {
 public:
  TemporaryPrefix() {
    std::string pattern = (std::filesystem::temp_directory_path() / "prefix_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) {
      throw std::runtime_error("cannot make " + pattern);
    }
    path_ = pattern;
    std::filesystem::create_directories(index());
  }
  TemporaryPrefix(const TemporaryPrefix&) = delete;
  TemporaryPrefix& operator=(const TemporaryPrefix&) = delete;
  ~TemporaryPrefix() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  const std::filesystem::path& path() const { return path_; }

  /// Writes the index file of a package.
  void add(const std::string& package, const std::string& content) const {
    std::ofstream(index() / package) << content;
  }

  std::filesystem::path index() const {
    return path_ / "share/ament_index/resource_index/pipescout_components";
  }

 private:
  std::filesystem::path path_;
};

/// The library of loadable_components.cpp: it stands beside the test's executable.
inline std::filesystem::path loadable_components() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() /
         "libloadable_components.so";
}
