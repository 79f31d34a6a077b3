// SPDX-License-Identifier: Apache-2.0
// The bytes on the wire are those of the classes that fastddsgen wrote.
#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "golden_file.hpp"
#include "pipescout/idl/field_access.hpp"
#include "pipescout/idl/message_type.hpp"

namespace pipescout {
namespace {

using testing::GoldenMessage;

std::vector<std::byte> serialized(const MessageType& type, const void* message) {
  std::vector<std::byte> bytes(type.serialized_size(message));
  EXPECT_EQ(type.serialize(message, bytes), bytes.size());
  return bytes;
}

TEST(GoldenTest, EveryMessageIsReadAndWrittenAsBefore) {
  const auto messages = testing::read_golden_files(GOLDEN_DIR);
  ASSERT_EQ(messages.size(), 290u);
  for (const GoldenMessage& golden : messages) {
    SCOPED_TRACE(golden.type + " " + golden.kind);
    const auto* const type = find_message_type(golden.type);
    ASSERT_NE(type, nullptr);
    const auto message = type->create();
    ASSERT_TRUE(type->deserialize(golden.cdr, message.get()));
    EXPECT_EQ(serialized(*type, message.get()), golden.cdr);
    if (golden.kind == "default") {
      EXPECT_EQ(serialized(*type, type->create().get()), golden.cdr);
    }
  }
}

/// Copies a message field by field through the tables of its type.
void copy(const MessageType& type, const void* from, void* to) {
  for (const MessageField& field : type.fields) {
    const FieldView source(field, from);
    FieldEditor target(field, to);
    if (field.shape == FieldShape::kSequence) {
      target.resize(source.size());
    }
    for (std::size_t i = 0; i < source.size(); ++i) {
      if (field.kind == FieldKind::kMessage) {
        copy(field.message(), source.message(i).message, target.message(i));
      } else if (field.kind == FieldKind::kString || field.kind == FieldKind::kWString) {
        target.set(i, source.text(i));
      } else {
        target.set(i, source.scalar(i));
      }
    }
  }
}

TEST(GoldenTest, TheFieldTablesReachEveryByte) {
  for (const GoldenMessage& golden : testing::read_golden_files(GOLDEN_DIR)) {
    SCOPED_TRACE(golden.type + " " + golden.kind);
    const auto* const type = find_message_type(golden.type);
    ASSERT_NE(type, nullptr);
    const auto message = type->create();
    ASSERT_TRUE(type->deserialize(golden.cdr, message.get()));
    const auto twin = type->create();
    copy(*type, message.get(), twin.get());
    EXPECT_EQ(serialized(*type, twin.get()), golden.cdr);
  }
}

}  // namespace
}  // namespace pipescout
