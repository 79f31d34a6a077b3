// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "pipescout/idl/message_field.hpp"

/// Messages whose class the program does not know: what fields a type has, read from its .idl file,
/// and what values they have, read from the bytes on the wire. For tools (printing, recording,
/// plotting); components use the generated classes.
namespace pipescout {

struct MessageDescription;

struct FieldDescription {
  std::string name;  ///< as in ROS: without the '_' that escapes a word of IDL
  FieldKind kind = FieldKind::kBool;
  FieldShape shape = FieldShape::kSingle;
  std::size_t length = 0;         ///< array: elements; sequence: at most so many, 0 for no bound
  std::size_t string_length = 0;  ///< strings: at most so many characters, 0 for no bound
  std::shared_ptr<const MessageDescription> message;  ///< for kMessage, else null
};

/// A number or truth value; `char` and `octet` are unsigned numbers.
using ScalarValue = std::variant<bool, std::int64_t, std::uint64_t, double>;

struct ConstantDescription {
  std::string name;
  FieldKind kind = FieldKind::kBool;
  std::variant<ScalarValue, std::string> value;
};

struct MessageDescription {
  std::string name;  ///< "sensor_msgs/msg/Image"
  std::vector<FieldDescription> fields;
  std::vector<ConstantDescription> constants;
};

/// An .idl file cannot be read; what() is "file:line:column: message".
class IdlError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The message types of a tree of .idl files, `<root>/<package>/<msg|srv>/<Type>.idl`, each read
/// when it is first asked for. Reads the subset of IDL that ROS 2 generates from .msg and .srv
/// files: modules, structs, constants, arrays, (bounded) sequences and strings, typedefs of these,
/// includes and annotations. Thread-safe.
class MessageDescriptions {
 public:
  explicit MessageDescriptions(std::filesystem::path root);

  /// The types that this program was built with: the tree beside the library of wire types.
  /// Throws IdlError when it is not there.
  [[nodiscard]] static MessageDescriptions& installed();

  /// `type`: "sensor_msgs/msg/Image", or half of a service, "std_srvs/srv/Trigger_Request".
  /// Throws IdlError when there is no such type, or its file or one that it includes is wrong.
  [[nodiscard]] std::shared_ptr<const MessageDescription> find(std::string_view type);

  [[nodiscard]] const std::filesystem::path& root() const noexcept { return root_; }

 private:
  std::filesystem::path root_;
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<const MessageDescription>, std::less<>> known_;
};

/// The elements of an array or sequence of numbers or truth values, packed in the byte order of
/// this machine.
class PrimitiveArray {
 public:
  PrimitiveArray(FieldKind kind, std::vector<std::byte> bytes);
  [[nodiscard]] FieldKind kind() const noexcept { return kind_; }
  [[nodiscard]] std::size_t size() const noexcept { return bytes_.size() / size_of(kind_); }
  /// Not checked: `index` < size().
  [[nodiscard]] ScalarValue operator[](std::size_t index) const;
  [[nodiscard]] std::span<const std::byte> bytes() const noexcept { return bytes_; }

 private:
  FieldKind kind_;
  std::vector<std::byte> bytes_;
};

struct DynamicMessage;

/// A field's value: a single scalar, string or message; or an array or sequence of them.
using DynamicValue =
    std::variant<ScalarValue, std::string, std::shared_ptr<const DynamicMessage>, PrimitiveArray,
                 std::vector<std::string>, std::vector<DynamicMessage>>;

struct DynamicMessage {
  std::shared_ptr<const MessageDescription> type;
  std::vector<DynamicValue> values;  ///< one per field of the type
};

/// A field somewhere in a message; both point into it.
struct FieldReference {
  const FieldDescription* field;
  const DynamicValue* value;
};

/// Finds "header.stamp.sec". Throws std::invalid_argument naming the part of the path that is no
/// field of its message, or that lies below something that is no message.
[[nodiscard]] FieldReference find_field(const DynamicMessage& message, std::string_view path);

/// Bytes are no message of the type; what() names the field and the byte.
class MalformedMessage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads CDR of either byte order with its encapsulation header. Throws MalformedMessage for
/// truncated or impossible bytes; never reads past the end, and allocates in proportion to the
/// number of bytes only. Bytes behind the message are ignored, as DDS pads a payload.
[[nodiscard]] DynamicMessage read_message(const std::shared_ptr<const MessageDescription>& type,
                                          std::span<const std::byte> cdr);

}  // namespace pipescout
