// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

#include "pipescout/idl/message_type.hpp"

/// Messages from YAML, as `ros2 topic pub` takes them.
namespace pipescout::host {

/// The YAML does not fit the message; what() names the field: "header.stamp.sec: ...".
class YamlMessageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Sets the fields of `message` that the YAML mapping names; the others stay as they are. Whatever
/// `to_yaml` writes in full is read back as the same message: a `byte` may be a number or, as it is
/// shown, the character of that number. An empty text names no field. Throws YamlMessageError.
void set_from_yaml(const std::string& yaml, const MessageType& type, void* message);

}  // namespace pipescout::host
