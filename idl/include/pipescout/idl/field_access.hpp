// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "pipescout/idl/message_type.hpp"

/// Access to fields of messages whose class is unknown at compile time, by the table in
/// MessageType. For tools (printing, recording, publishing); components use the classes.
///
/// Reading functions may be called from any thread as long as the message is not changed. Functions
/// with an index do not check it.
namespace pipescout {

/// A number or truth value; `char` and `byte` are unsigned numbers.
using ScalarValue = std::variant<bool, std::int64_t, std::uint64_t, double>;

/// A message and its type. Does not keep the message alive.
struct MessageView {
  const MessageType* type = nullptr;
  const void* message = nullptr;
};

/// A field of a message. Does not keep the message alive.
class FieldView {
 public:
  /// `message`: the object that holds the field.
  FieldView(const MessageField& field, const void* message);

  [[nodiscard]] const MessageField& field() const noexcept { return *field_; }
  /// Elements; 1 for a single value.
  [[nodiscard]] std::size_t size() const;

  /// Numbers and truth values.
  [[nodiscard]] ScalarValue scalar(std::size_t index = 0) const;
  /// Strings; a wide one as UTF-8.
  [[nodiscard]] std::string text(std::size_t index = 0) const;
  /// Messages.
  [[nodiscard]] MessageView message(std::size_t index = 0) const;

 private:
  [[nodiscard]] const std::byte* element(std::size_t index) const;

  const MessageField* field_;
  const std::byte* data_;  ///< the field in the object
};

/// Finds a field by its path, such as "header.stamp.sec". Throws std::invalid_argument naming the
/// part of the path that is not a field of its message, or whose parent is not a message.
[[nodiscard]] FieldView find_field(MessageView message, std::string_view path);

/// The field of that name, or nullptr.
[[nodiscard]] const MessageField* find_field(const MessageType& type,
                                             std::string_view name) noexcept;

/// A writable field of a message.
class FieldEditor {
 public:
  FieldEditor(const MessageField& field, void* message);

  /// Sequences only. Throws std::length_error beyond the bound.
  void resize(std::size_t size);

  /// Numbers and truth values. Throws std::invalid_argument when the value is of another kind (a
  /// boolean for a number, a fraction for an integer), std::out_of_range when it exceeds the range
  /// of the field.
  void set(std::size_t index, const ScalarValue& value);
  /// Strings. Throws std::length_error beyond the bound, std::invalid_argument when the value of a
  /// wide string is not UTF-8.
  void set(std::size_t index, std::string_view text);
  /// Messages: the object of that element.
  [[nodiscard]] void* message(std::size_t index) const;

 private:
  [[nodiscard]] std::byte* element(std::size_t index) const;

  const MessageField* field_;
  std::byte* data_;
};

}  // namespace pipescout
