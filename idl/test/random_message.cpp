// SPDX-License-Identifier: Apache-2.0
#include "random_message.hpp"

#include <algorithm>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/idl/field_access.hpp"

namespace pipescout::testing {
namespace {

/// Characters of one to three bytes in UTF-8, none of them NUL.
std::string any_text(std::size_t bound) {
  const std::vector<std::string> kCharacters{"a", "Z", "0", " ", "\n", "\"", "ö", "λ", "管"};
  std::string text;
  const auto length = *rc::gen::inRange<std::size_t>(0, 6);
  for (std::size_t i = 0; i < length; ++i) {
    const auto character = *rc::gen::elementOf(kCharacters);
    if (bound == 0 || text.size() + character.size() <= bound) {
      text += character;
    }
  }
  return text;
}

ScalarValue any_scalar(FieldKind kind) {
  switch (kind) {
    case FieldKind::kBool:
      return *rc::gen::arbitrary<bool>();
    case FieldKind::kInt8:
      return std::int64_t{*rc::gen::arbitrary<std::int8_t>()};
    case FieldKind::kInt16:
      return std::int64_t{*rc::gen::arbitrary<std::int16_t>()};
    case FieldKind::kInt32:
      return std::int64_t{*rc::gen::arbitrary<std::int32_t>()};
    case FieldKind::kInt64:
      return *rc::gen::arbitrary<std::int64_t>();
    case FieldKind::kUInt16:
      return std::uint64_t{*rc::gen::arbitrary<std::uint16_t>()};
    case FieldKind::kUInt32:
      return std::uint64_t{*rc::gen::arbitrary<std::uint32_t>()};
    case FieldKind::kUInt64:
      return *rc::gen::arbitrary<std::uint64_t>();
    case FieldKind::kFloat32:
      return double{*rc::gen::arbitrary<float>()};
    case FieldKind::kFloat64:
      return *rc::gen::arbitrary<double>();
    default:
      return std::uint64_t{*rc::gen::arbitrary<std::uint8_t>()};
  }
}

void fill(const MessageType& type, void* message) {
  for (const MessageField& field : type.fields) {
    FieldEditor editor(field, message);
    std::size_t count = 1;
    if (field.shape == FieldShape::kArray) {
      count = field.length;
    } else if (field.shape == FieldShape::kSequence) {
      const std::size_t most = field.length != 0 ? std::min<std::size_t>(field.length, 4) : 4;
      count = *rc::gen::inRange<std::size_t>(0, most + 1);
      editor.resize(count);
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (field.kind == FieldKind::kMessage) {
        fill(field.message(), editor.message(i));
      } else if (field.kind == FieldKind::kString || field.kind == FieldKind::kWString) {
        editor.set(i, any_text(field.string_length));
      } else {
        editor.set(i, any_scalar(field.kind));
      }
    }
  }
}

}  // namespace

void showValue(const AnyMessage& value, std::ostream& stream) {
  std::vector<std::byte> bytes(value.type->serialized_size(value.message.get()));
  bytes.resize(value.type->serialize(value.message.get(), bytes));
  stream << value.type->name << " in CDR:" << std::hex;
  for (const auto byte : bytes) {
    stream << ' ' << std::to_integer<unsigned>(byte);
  }
}

rc::Gen<AnyMessage> any_message(const MessageType& type) {
  return rc::gen::exec([&type] {
    auto message = type.create();
    fill(type, message.get());
    return AnyMessage{&type, std::move(message)};
  });
}

}  // namespace pipescout::testing
