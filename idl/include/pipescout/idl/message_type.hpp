// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

#include "pipescout/idl/message_field.hpp"

namespace pipescout {

/// Everything that the runtime needs to know about one wire type, as data: no template is needed
/// beyond this point.
///
/// All functions are safe to call from any thread at once, as long as no two calls share a message
/// of which one changes it. `message` always points to an object of the described type.
struct MessageType {
  /// ROS name: "sensor_msgs/msg/Image", and for the halves of a service
  /// "std_srvs/srv/Trigger_Request", "std_srvs/srv/Trigger_Response".
  std::string_view name;

  /// The name under which DDS knows the type, as ROS 2 writes it: "sensor_msgs::msg::dds_::Image_".
  std::string_view dds_name;

  /// Makes a message with the default value of each field (zero, empty, or what its .idl says).
  std::shared_ptr<void> (*create)();

  /// Bytes that `serialize` needs, with the 4 bytes of the encapsulation header.
  std::size_t (*serialized_size)(const void* message);

  /// Writes the message as little-endian CDR behind its encapsulation header.
  /// Returns the bytes written, or 0 when `buffer` is too small or a string or sequence exceeds its
  /// bound (the content of `buffer` is then unspecified).
  /// A string ends at its first NUL character, since CDR strings cannot hold one.
  std::size_t (*serialize)(const void* message, std::span<std::byte> buffer);

  /// Reads a message in CDR of either byte order. Returns false when the bytes are truncated or
  /// malformed, or a string or sequence exceeds its bound; the message then holds unspecified
  /// values, but stays usable. Never throws, never reads past the end, and never allocates more
  /// than in proportion to the size of the buffer. Bytes behind the message are ignored, as DDS
  /// pads a payload.
  bool (*deserialize)(std::span<const std::byte> buffer, void* message);

  /// The fields in their order; empty for a type that is not made by the generator.
  std::span<const MessageField> fields{};

  std::span<const MessageConstant> constants{};

  /// The definition with its comments as the lines of a .msg file.
  std::string_view definition{};
};

/// The type support of the generated message class `T`. Each generated header, such as
/// <sensor_msgs/msg/image.hpp>, declares the specialisation for its own classes; for any other
/// class the call does not compile.
template <class T>
const MessageType& message_type() = delete;

/// A class that can be sent: one that the generator wrote, whose header is included.
template <class T>
concept Message = requires {
  message_type<T>();
};

/// The type of that ROS name, or nullptr when this library does not hold it.
const MessageType* find_message_type(std::string_view name) noexcept;

/// All types of this library, sorted by name.
std::span<const MessageType* const> message_types() noexcept;

namespace idl {

/// What the generated code reads and writes CDR with.
class CdrReader;
class CdrSize;
class CdrWriter;

}  // namespace idl

}  // namespace pipescout
