// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// Packages of which only the definitions are of use here: those of a ROS 2 installation or
/// workspace.
namespace pipescout::idl {

/// Where ROS 2 lists the definitions of a package in a prefix.
[[nodiscard]] std::filesystem::path definition_list(const std::filesystem::path& prefix,
                                                    const std::string& package);

/// The interfaces in that list, as "std_srvs/srv/Trigger", sorted. Throws MessageTypeError when it
/// cannot be read.
[[nodiscard]] std::vector<std::string> read_definition_list(const std::filesystem::path& list);

/// The file in share/PACKAGE that defines the interface: as the author wrote it, in .msg, .srv or
/// .action, where it is there, and in .idl otherwise. Throws MessageTypeError when there is none.
[[nodiscard]] std::filesystem::path definition_file(const std::filesystem::path& prefix,
                                                    std::string_view interface_name);

/// The structures that ROS 2 makes of an interface: "std_srvs/srv/Trigger_Request", ...
[[nodiscard]] std::vector<std::string> structure_names(const std::string& interface_name);

}  // namespace pipescout::idl
