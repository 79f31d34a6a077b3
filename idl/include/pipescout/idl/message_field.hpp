// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace pipescout {

struct MessageType;

/// The types of rosidl. `std::string` holds kString, `std::u16string` kWString; of numbers,
/// kOctet (ROS `byte`) and kChar are `std::uint8_t`, the others what their name says.
enum class FieldKind : std::uint8_t {
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

/// The IDL name: "boolean", "octet", "uint8", "float", "double", "string"; "message".
[[nodiscard]] std::string_view to_string(FieldKind kind) noexcept;
/// Bytes on the wire and in memory; 0 for strings and messages.
[[nodiscard]] std::size_t size_of(FieldKind kind) noexcept;

enum class FieldShape : std::uint8_t { kSingle, kArray, kSequence };

/// Access to a sequence in memory, a std::vector or a BoundedVector, whose class is unknown.
struct SequenceAccess {
  std::size_t (*size)(const void* sequence);
  /// New elements get their default value. Throws std::length_error beyond the bound.
  void (*resize)(void* sequence, std::size_t size);
  /// The contiguous elements; nullptr for bool, because std::vector<bool> has no bool objects.
  void* (*data)(void* sequence);
  bool (*get_bool)(const void* sequence, std::size_t index);  ///< bool only
  void (*set_bool)(void* sequence, std::size_t index, bool value);
};

/// One field of a message class.
struct MessageField {
  std::string_view name;  ///< as in ROS
  FieldKind kind = FieldKind::kBool;
  FieldShape shape = FieldShape::kSingle;
  std::size_t element_size = 0;   ///< bytes in memory: of the field, or one of its elements
  std::size_t length = 0;         ///< array: number of elements; sequence: upper bound, 0 for none
  std::size_t string_length = 0;  ///< strings: upper bound of characters, 0 for none
  std::size_t offset = 0;         ///< in the object
  const MessageType& (*message)() = nullptr;  ///< for kMessage
  const SequenceAccess* sequence = nullptr;   ///< for kSequence
  std::string_view default_value{};           ///< as in a .msg file; empty: zero or empty
};

/// A constant of a message; `value` is written as in a .msg file, texts in quotes.
struct MessageConstant {
  std::string_view name;
  FieldKind kind = FieldKind::kBool;
  std::string_view value;
};

}  // namespace pipescout
