// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "temporary_folder.hpp"

namespace pipescout::testing {

/// A prefix that is AMENT_PREFIX_PATH as long as it lives.
class AmentPrefix {
 public:
  AmentPrefix() { setenv("AMENT_PREFIX_PATH", folder_.path().c_str(), 1); }
  ~AmentPrefix() { unsetenv("AMENT_PREFIX_PATH"); }
  AmentPrefix(const AmentPrefix&) = delete;
  AmentPrefix& operator=(const AmentPrefix&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return folder_.path(); }

  /// `file`: relative to the prefix.
  void write(const std::string& file, const std::string& text) const {
    std::filesystem::create_directories((path() / file).parent_path());
    std::ofstream(path() / file) << text;
  }

  /// What a package enters into an index of the ament resources.
  void write_entry(const std::string& index, const std::string& package,
                   const std::string& text) const {
    write("share/ament_index/resource_index/" + index + "/" + package, text);
  }

  /// A definition, "msg/Type.msg", of a package that ROS 2 has installed; listed with the others.
  void write_definition(const std::string& package, const std::string& file,
                        const std::string& text) const {
    write("share/" + package + "/" + file, text);
    const auto index = path() / "share/ament_index/resource_index/rosidl_interfaces";
    std::filesystem::create_directories(index);
    std::ofstream(index / package, std::ios::app) << file << '\n';
  }

 private:
  TemporaryFolder folder_;
};

}  // namespace pipescout::testing
