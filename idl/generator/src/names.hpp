// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "model.hpp"

namespace pipescout::generator {

/// rosidl's rule for header names: "NavSatFix" -> "nav_sat_fix", "TFMessage" -> "tf_message".
[[nodiscard]] std::string snake_case(std::string_view camel);

/// "std_msgs/msg/Header" -> "std_msgs::msg::Header".
[[nodiscard]] std::string scoped_name(std::string_view ros_name);

/// "std_msgs/msg/Header" -> "std_msgs::msg::dds_::Header_", as ROS 2 names it in DDS.
[[nodiscard]] std::string dds_name(std::string_view ros_name);

/// "std_msgs/msg/Header" -> "std_msgs", "msg", "Header".
struct NameParts {
  std::string package;
  std::string folder;
  std::string type;
};
[[nodiscard]] NameParts split_name(std::string_view ros_name);

/// The file that defines it: "std_srvs/srv/Trigger_Request" -> "std_srvs/srv/Trigger". Of actions
/// also "X_SendGoal_Request" -> "X".
[[nodiscard]] std::string defining_interface(std::string_view ros_name);

/// "msg", "srv" or "action".
[[nodiscard]] std::string_view folder_of(InterfaceKind kind) noexcept;

[[nodiscard]] bool is_cpp_keyword(std::string_view word) noexcept;
/// Words that Cyclone's and other IDL 4.2 compilers take only with a leading underscore.
[[nodiscard]] bool is_idl_keyword(std::string_view word) noexcept;

/// The rules of rosidl for names; each throws DefinitionError.
void check_package_name(std::string_view name, const Location& location);
void check_type_name(std::string_view name, const Location& location);
void check_field_name(std::string_view name, const Location& location);
void check_constant_name(std::string_view name, const Location& location);

}  // namespace pipescout::generator
