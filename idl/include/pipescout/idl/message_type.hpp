// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/idl/message_field.hpp"

namespace pipescout {

/// Description of one wire type as data, so that the runtime needs no templates.
///
/// All functions are safe to call from any thread at once, as long as no two calls share a message
/// of which one changes it. `message` always points to an object of the described type.
struct MessageType {
  /// ROS name: "sensor_msgs/msg/Image", and for the halves of a service
  /// "std_srvs/srv/Trigger_Request", "std_srvs/srv/Trigger_Response".
  std::string_view name;

  /// The name under which DDS knows the type, as ROS 2 writes it: "sensor_msgs::msg::dds_::Image_".
  std::string_view dds_name;

  /// Creates a message with the default value of each field (zero, empty, or as in its definition).
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
  /// values, but stays usable. Never throws, never reads past the end, and allocates at most in
  /// proportion to the size of the buffer. Bytes after the message are ignored, as DDS pads a
  /// payload.
  bool (*deserialize)(std::span<const std::byte> buffer, void* message);

  /// The fields in their order; empty for a type that was not generated.
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

/// A message class: generated, and its header is included.
template <class T>
concept Message = requires {
  message_type<T>();
};

/// The type of that ROS name, or nullptr when neither this library nor an installed package has it.
/// Types that are not built in are loaded on first use and stay loaded; see `load_message_type`.
/// Safe to call from any thread.
const MessageType* find_message_type(std::string_view name) noexcept;

/// The type does not exist, or cannot be loaded; what() gives the reason.
class MessageTypeError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// As `find_message_type`, but throws MessageTypeError when there is none. A message package, built
/// with `pipescout_generate_messages`, lists them in
/// `<prefix>/share/ament_index/resource_index/pipescout_messages/<package>`, one line
/// `type;library` each, with the library relative to the prefix; the first prefix of
/// `installed_prefixes` with the package is used.
const MessageType& load_message_type(std::string_view name);

/// All types of this library, sorted by name.
std::span<const MessageType* const> message_types() noexcept;

/// The names of all types that `find_message_type` can find, sorted: those of this library and
/// those in the lists of installed packages. Loads no library; unreadable lists are ignored.
std::vector<std::string> known_message_types();

namespace idl {

/// CDR reader and writer of the generated code.
class CdrReader;
class CdrSize;
class CdrWriter;

}  // namespace idl

}  // namespace pipescout
