// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

#include "pipescout/idl/message_type.hpp"

namespace pipescout::idl {

class LoadedType;
class ObjectType;

/// The functions of MessageType and MessageField know their type by their address alone, since
/// generated tables are constants. For types that are made at run time this many sets of functions
/// are compiled ahead. All message packages of ROS 2 Humble's desktop define fewer structures, and
/// a process loads only those that it is asked for.
inline constexpr std::size_t kTypeSlots = 1024;

struct SlotFunctions {
  std::shared_ptr<void> (*create)();
  std::size_t (*serialized_size)(const void* message);
  std::size_t (*serialize)(const void* message, std::span<std::byte> buffer);
  bool (*deserialize)(std::span<const std::byte> buffer, void* message);
};

/// The functions of the type of that name, which stays. Throws MessageTypeError when all are in
/// use. Not thread-safe; calls of the functions are.
[[nodiscard]] const SlotFunctions& claim_type_slot(const LoadedType& type, std::string_view name);

/// What MessageField::message is for a field of that type; the same limit and errors.
using MessageFunction = const MessageType& (*)();
[[nodiscard]] MessageFunction message_function(const ObjectType& type);

}  // namespace pipescout::idl
