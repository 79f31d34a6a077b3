// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "pipescout/files/testing/temporary_folder.hpp"

/// An installation prefix in a temporary folder, with an index of component classes.
class TemporaryPrefix {
 public:
  TemporaryPrefix() { std::filesystem::create_directories(index()); }

  const std::filesystem::path& path() const { return folder_.path(); }

  /// Writes the index file of a package.
  void add(const std::string& package, const std::string& content) const {
    std::ofstream(index() / package) << content;
  }

  std::filesystem::path index() const {
    return path() / "share/ament_index/resource_index/pipescout_components";
  }

 private:
  pipescout::testing::TemporaryFolder folder_;
};

/// The library of loadable_components.cpp: it stands beside the test's executable.
inline std::filesystem::path loadable_components() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() /
         "libloadable_components.so";
}
