// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// What a definition file says, whichever of the four formats (.idl, .msg, .srv, .action) it is
/// written in.
namespace pipescout::generator {

/// A place in a definition file, for messages.
struct Location {
  std::string file;
  int line = 0;
};

/// The types that rosidl knows, in the order of pipescout::FieldKind.
enum class Kind : std::uint8_t {
  kBool,
  kOctet,
  kChar,
  kInt8,
  kUInt8,
  kInt16,
  kUInt16,
  kInt32,
  kUInt32,
  kInt64,
  kUInt64,
  kFloat32,
  kFloat64,
  kString,
  kWString,
  kMessage
};

/// Bytes of a number in memory and in CDR; 0 for strings and messages.
[[nodiscard]] std::size_t size_of(Kind kind) noexcept;
[[nodiscard]] bool is_text(Kind kind) noexcept;
[[nodiscard]] bool is_signed(Kind kind) noexcept;
[[nodiscard]] bool is_floating_point(Kind kind) noexcept;

enum class Shape : std::uint8_t { kSingle, kArray, kSequence };

struct Type {
  Kind kind = Kind::kBool;
  Shape shape = Shape::kSingle;
  std::size_t length = 0;       ///< array: elements; sequence: at most so many, 0 for no bound
  std::size_t text_length = 0;  ///< strings: at most so many characters, 0 for no bound
  std::string message;          ///< kMessage: "std_msgs/msg/Header"
};

/// A number (floating point ones as `double`, char and octet as unsigned), truth value or text.
using Value = std::variant<bool, std::int64_t, std::uint64_t, double, std::string>;

/// Comments of a definition, without the signs that mark them.
struct Comments {
  std::vector<std::string> above;  ///< the lines directly above
  std::string trailing;            ///< on the same line
};

struct Constant {
  std::string name;
  Type type;
  Value value;
  Comments comments;
  Location location;
};

struct Field {
  std::string name;
  Type type;
  std::optional<std::vector<Value>> default_value;  ///< a single value: one element
  std::string unit;                                 ///< of the annotation @unit
  bool is_key = false;
  Comments comments;
  Location location;
};

struct Structure {
  std::string name;                   ///< "std_srvs/srv/Trigger_Request"
  std::vector<std::string> comments;  ///< about it as a whole
  std::vector<Constant> constants;
  std::vector<Field> fields;
  Location location;
  std::vector<std::string> closing_comments;  ///< behind the last field
};

enum class InterfaceKind : std::uint8_t { kMessage, kService, kAction };

/// One definition file.
struct Interface {
  std::string package;
  InterfaceKind kind = InterfaceKind::kMessage;
  std::string name;    ///< "Trigger"
  std::string folder;  ///< "srv": the middle part of the ROS name
  std::string file;    ///< as it was opened
  /// A message; the request and response of a service; the goal, result and feedback of an action,
  /// then the five structures that ROS 2 derives from them.
  std::vector<Structure> structures;
};

/// The one member that ROS 2 gives a structure without fields, since IDL knows no empty ones.
inline constexpr std::string_view kPlaceholder = "structure_needs_at_least_one_member";

[[nodiscard]] bool is_empty(const Structure& structure);

}  // namespace pipescout::generator
