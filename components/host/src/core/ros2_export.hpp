// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

/// Message packages for a ROS 2 workspace.
namespace pipescout::host {

/// The package cannot be written as .msg, .srv and .action files; what() names the type and why.
class ExportError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct ExportedPackage {
  std::filesystem::path folder;
  std::size_t interfaces = 0;
  /// Packages that its messages use: the workspace needs them too.
  std::vector<std::string> dependencies;
};

/// Writes the messages, services and actions of `package` as a package that ROS 2 (Humble or later)
/// builds: package.xml, CMakeLists.txt, msg/, srv/, action/, with the comments of the definitions
/// in ASCII. It stands in `folder`/`package`, or in `folder` itself if that is named as the
/// package. Present files of these names are replaced. Throws ExportError, MessageTypeError.
ExportedPackage export_to_ros2(const std::string& package, const std::filesystem::path& folder);

}  // namespace pipescout::host
