// SPDX-License-Identifier: Apache-2.0
#include "pipescout/idl/field_access.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>

#include "utf16.hpp"

namespace pipescout {
namespace {

template <class T>
T load(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return value;
}

template <class T>
void store(std::byte* to, T value) {
  std::memcpy(to, &value, sizeof(T));
}

ScalarValue load_scalar(FieldKind kind, const std::byte* from) {
  switch (kind) {
    case FieldKind::kBool:
      return load<bool>(from);
    case FieldKind::kInt8:
      return std::int64_t{load<std::int8_t>(from)};
    case FieldKind::kInt16:
      return std::int64_t{load<std::int16_t>(from)};
    case FieldKind::kInt32:
      return std::int64_t{load<std::int32_t>(from)};
    case FieldKind::kInt64:
      return load<std::int64_t>(from);
    case FieldKind::kUInt16:
      return std::uint64_t{load<std::uint16_t>(from)};
    case FieldKind::kUInt32:
      return std::uint64_t{load<std::uint32_t>(from)};
    case FieldKind::kUInt64:
      return load<std::uint64_t>(from);
    case FieldKind::kFloat32:
      return double{load<float>(from)};
    case FieldKind::kFloat64:
      return load<double>(from);
    default:
      return std::uint64_t{load<std::uint8_t>(from)};
  }
}

[[noreturn]] void refuse_kind(const MessageField& field, const char* what) {
  throw std::invalid_argument(std::string(field.name) + ": " + what + " is no " +
                              std::string(to_string(field.kind)));
}

[[noreturn]] void refuse_range(const MessageField& field, const std::string& value) {
  throw std::out_of_range(std::string(field.name) + ": " + value + " does not fit into " +
                          std::string(to_string(field.kind)));
}

template <class T>
T whole_number(const MessageField& field, const ScalarValue& value) {
  const auto narrowed = [&](auto number) -> T {
    if (!std::in_range<T>(number)) {
      refuse_range(field, std::to_string(number));
    }
    return static_cast<T>(number);
  };
  if (const auto* const number = std::get_if<std::int64_t>(&value)) {
    return narrowed(*number);
  }
  if (const auto* const number = std::get_if<std::uint64_t>(&value)) {
    return narrowed(*number);
  }
  refuse_kind(field, std::holds_alternative<bool>(value) ? "a truth value" : "a fraction");
}

double real_number(const MessageField& field, const ScalarValue& value) {
  if (const auto* const number = std::get_if<double>(&value)) {
    return *number;
  }
  if (const auto* const number = std::get_if<std::int64_t>(&value)) {
    return static_cast<double>(*number);
  }
  if (const auto* const number = std::get_if<std::uint64_t>(&value)) {
    return static_cast<double>(*number);
  }
  refuse_kind(field, "a truth value");
}

void store_scalar(const MessageField& field, std::byte* to, const ScalarValue& value) {
  switch (field.kind) {
    case FieldKind::kBool:
      if (!std::holds_alternative<bool>(value)) {
        refuse_kind(field, "a number");
      }
      return store(to, std::get<bool>(value));
    case FieldKind::kInt8:
      return store(to, whole_number<std::int8_t>(field, value));
    case FieldKind::kInt16:
      return store(to, whole_number<std::int16_t>(field, value));
    case FieldKind::kInt32:
      return store(to, whole_number<std::int32_t>(field, value));
    case FieldKind::kInt64:
      return store(to, whole_number<std::int64_t>(field, value));
    case FieldKind::kUInt16:
      return store(to, whole_number<std::uint16_t>(field, value));
    case FieldKind::kUInt32:
      return store(to, whole_number<std::uint32_t>(field, value));
    case FieldKind::kUInt64:
      return store(to, whole_number<std::uint64_t>(field, value));
    case FieldKind::kOctet:
    case FieldKind::kChar:
    case FieldKind::kUInt8:
      return store(to, whole_number<std::uint8_t>(field, value));
    case FieldKind::kFloat64:
      return store(to, real_number(field, value));
    case FieldKind::kFloat32: {
      const double number = real_number(field, value);
      if (std::isfinite(number) && std::abs(number) > std::numeric_limits<float>::max()) {
        refuse_range(field, std::to_string(number));
      }
      return store(to, static_cast<float>(number));
    }
    case FieldKind::kString:
    case FieldKind::kWString:
    case FieldKind::kMessage:
      refuse_kind(field, "a number");
  }
}

/// The elements of a sequence, for reading only.
const std::byte* elements(const MessageField& field, const std::byte* sequence) {
  // The function takes a changeable sequence for the sake of editors, and changes nothing itself.
  return static_cast<const std::byte*>(
      field.sequence->data(const_cast<void*>(static_cast<const void*>(sequence))));
}

bool is_vector_of_bool(const MessageField& field) {
  return field.shape == FieldShape::kSequence && field.kind == FieldKind::kBool;
}

}  // namespace

FieldView::FieldView(const MessageField& field, const void* message)
    : field_(&field), data_(static_cast<const std::byte*>(message) + field.offset) {}

std::size_t FieldView::size() const {
  switch (field_->shape) {
    case FieldShape::kSingle:
      break;
    case FieldShape::kArray:
      return field_->length;
    case FieldShape::kSequence:
      return field_->sequence->size(data_);
  }
  return 1;
}

const std::byte* FieldView::element(std::size_t index) const {
  const auto* const first =
      field_->shape == FieldShape::kSequence ? elements(*field_, data_) : data_;
  return first + index * field_->element_size;
}

ScalarValue FieldView::scalar(std::size_t index) const {
  if (is_vector_of_bool(*field_)) {
    return field_->sequence->get_bool(data_, index);
  }
  return load_scalar(field_->kind, element(index));
}

std::string FieldView::text(std::size_t index) const {
  const void* const text = element(index);
  if (field_->kind == FieldKind::kWString) {
    return idl::to_utf8(*static_cast<const std::u16string*>(text));
  }
  return *static_cast<const std::string*>(text);
}

MessageView FieldView::message(std::size_t index) const {
  return {&field_->message(), element(index)};
}

FieldView find_field(MessageView message, std::string_view path) {
  for (std::size_t begin = 0;;) {
    const auto end = std::min(path.find('.', begin), path.size());
    const auto name = path.substr(begin, end - begin);
    const auto* const field = find_field(*message.type, name);
    if (field == nullptr) {
      throw std::invalid_argument("'" + std::string(name) + "' is not a field of " +
                                  std::string(message.type->name));
    }
    const FieldView view(*field, message.message);
    if (end == path.size()) {
      return view;
    }
    if (field->kind != FieldKind::kMessage || field->shape != FieldShape::kSingle) {
      throw std::invalid_argument("'" + std::string(path.substr(0, end)) + "' has no fields");
    }
    message = view.message();
    begin = end + 1;
  }
}

const MessageField* find_field(const MessageType& type, std::string_view name) noexcept {
  const auto found = std::ranges::find(type.fields, name, &MessageField::name);
  return found != type.fields.end() ? &*found : nullptr;
}

FieldEditor::FieldEditor(const MessageField& field, void* message)
    : field_(&field), data_(static_cast<std::byte*>(message) + field.offset) {}

void FieldEditor::resize(std::size_t size) {
  field_->sequence->resize(data_, size);
}

std::byte* FieldEditor::element(std::size_t index) const {
  auto* const first = field_->shape == FieldShape::kSequence
                          ? static_cast<std::byte*>(field_->sequence->data(data_))
                          : data_;
  return first + index * field_->element_size;
}

void FieldEditor::set(std::size_t index, const ScalarValue& value) {
  if (!is_vector_of_bool(*field_)) {
    store_scalar(*field_, element(index), value);
    return;
  }
  if (!std::holds_alternative<bool>(value)) {
    refuse_kind(*field_, "a number");
  }
  field_->sequence->set_bool(data_, index, std::get<bool>(value));
}

void FieldEditor::set(std::size_t index, std::string_view text) {
  const auto check = [this](std::size_t length) {
    if (field_->string_length != 0 && length > field_->string_length) {
      throw std::length_error(std::string(field_->name) + ": a text of " + std::to_string(length) +
                              " characters exceeds the bound of " +
                              std::to_string(field_->string_length));
    }
  };
  void* const target = element(index);
  if (field_->kind == FieldKind::kWString) {
    auto wide = idl::to_utf16(text);
    if (!wide) {
      throw std::invalid_argument(std::string(field_->name) + ": the text is no UTF-8");
    }
    check(wide->size());
    *static_cast<std::u16string*>(target) = *std::move(wide);
  } else if (field_->kind == FieldKind::kString) {
    check(text.size());
    *static_cast<std::string*>(target) = text;
  } else {
    refuse_kind(*field_, "a text");
  }
}

void* FieldEditor::message(std::size_t index) const {
  return element(index);
}

}  // namespace pipescout
