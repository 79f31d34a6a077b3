// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pipescout/idl/message_type.hpp"

/// The messages, services and actions of this installation, as `ros2 interface` sees them.
namespace pipescout::host {

enum class InterfaceKind { kMessage, kService, kAction };

struct InterfaceName {
  std::string package;
  InterfaceKind kind = InterfaceKind::kMessage;
  std::string type;

  /// "std_srvs/srv/Trigger"
  [[nodiscard]] std::string text() const;
};

/// "msg", "srv", "action".
[[nodiscard]] std::string_view folder_of(InterfaceKind kind) noexcept;

/// All, sorted by name.
[[nodiscard]] std::vector<InterfaceName> known_interfaces();

/// "std_srvs/srv/Trigger". Throws std::invalid_argument for what is no such name.
[[nodiscard]] InterfaceName parse_interface_name(std::string_view text);

/// The parts of its definition, in order: the message; request and response; goal, result and
/// feedback. Throws MessageTypeError when one is not known.
[[nodiscard]] std::vector<const MessageType*> parts_of(const InterfaceName& name);

struct ShowOptions {
  bool all_comments = false;  ///< those of nested messages too
  bool no_comments = false;
};

/// The definition; below each field of a message type come the fields of that type, indented by a
/// tab. Throws MessageTypeError.
[[nodiscard]] std::string show_interface(const InterfaceName& name, const ShowOptions& options);

}  // namespace pipescout::host
