// SPDX-License-Identifier: Apache-2.0
#include "pipescout/idl/field_access.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <limits>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <stdexcept>
#include <string>
#include <test_msgs/msg/everything.hpp>
#include <vector>

#include "all_types.hpp"
#include "random_message.hpp"

namespace pipescout {
namespace {

using test_msgs::msg::Everything;

std::string error_of(const MessageView& message, std::string_view path) {
  try {
    static_cast<void>(find_field(message, path));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "none";
}

/// The field of that name of an Everything.
const MessageField& field(std::string_view name) {
  const auto* const found = find_field(message_type<Everything>(), name);
  EXPECT_NE(found, nullptr) << name;
  return *found;
}

TEST(FieldAccessTest, FindsNestedFields) {
  nav_msgs::msg::Odometry odometry;
  odometry.header.stamp.sec = 7;
  odometry.pose.covariance[35] = 0.5;
  odometry.child_frame_id = "base_link";
  const MessageView view{&message_type<nav_msgs::msg::Odometry>(), &odometry};
  EXPECT_EQ(find_field(view, "header.stamp.sec").scalar(), ScalarValue(std::int64_t{7}));
  EXPECT_EQ(find_field(view, "pose.covariance").size(), 36u);
  EXPECT_EQ(find_field(view, "pose.covariance").scalar(35), ScalarValue(0.5));
  EXPECT_EQ(find_field(view, "child_frame_id").text(), "base_link");
  EXPECT_EQ(error_of(view, "header.stam.sec"), "'stam' is not a field of std_msgs/msg/Header");
  EXPECT_EQ(error_of(view, "child_frame_id.x"), "'child_frame_id' has no fields");
  EXPECT_EQ(error_of(view, "pose.covariance.x"), "'pose.covariance' has no fields");
  EXPECT_EQ(error_of(view, ""), "'' is not a field of nav_msgs/msg/Odometry");
}

TEST(FieldAccessTest, TheTableDescribesEveryKindAndShape) {
  const auto& short_texts = field("few_short_texts");
  EXPECT_EQ(short_texts.kind, FieldKind::kString);
  EXPECT_EQ(short_texts.shape, FieldShape::kSequence);
  EXPECT_EQ(short_texts.length, 3u);
  EXPECT_EQ(short_texts.string_length, 5u);
  EXPECT_EQ(field("wide").kind, FieldKind::kWString);
  EXPECT_EQ(field("octet").kind, FieldKind::kOctet);
  EXPECT_EQ(field("letter").kind, FieldKind::kUInt8);
  EXPECT_EQ(field("inner_array").shape, FieldShape::kArray);
  EXPECT_EQ(field("inner_array").length, 2u);
  EXPECT_EQ(field("inner_array").message().name, "test_msgs/msg/Inner");
  EXPECT_EQ(field("array_default").default_value, "[1, -2, 3]");
  EXPECT_EQ(field("i8").default_value, "");
  const auto& constants = message_type<Everything>().constants;
  ASSERT_EQ(constants.size(), 8u);
  EXPECT_EQ(constants[1].name, "SMALLEST");
  EXPECT_EQ(constants[1].kind, FieldKind::kInt64);
  EXPECT_EQ(constants[1].value, "-9223372036854775808");
  EXPECT_EQ(constants[4].value, "'say \"hello\"'");
}

TEST(FieldAccessTest, ValuesThatDoNotFitAreRefused) {
  Everything message;
  EXPECT_THROW(FieldEditor(field("i8"), &message).set(0, std::int64_t{128}), std::out_of_range);
  EXPECT_THROW(FieldEditor(field("u64"), &message).set(0, std::int64_t{-1}), std::out_of_range);
  EXPECT_THROW(
      FieldEditor(field("i64"), &message).set(0, std::numeric_limits<std::uint64_t>::max()),
      std::out_of_range);
  EXPECT_THROW(FieldEditor(field("f32"), &message).set(0, 1e39), std::out_of_range);
  EXPECT_THROW(FieldEditor(field("i8"), &message).set(0, 1.0), std::invalid_argument);
  EXPECT_THROW(FieldEditor(field("i8"), &message).set(0, true), std::invalid_argument);
  EXPECT_THROW(FieldEditor(field("truth"), &message).set(0, std::int64_t{1}),
               std::invalid_argument);
  EXPECT_THROW(FieldEditor(field("text"), &message).set(0, std::int64_t{1}), std::invalid_argument);
  EXPECT_THROW(FieldEditor(field("i8"), &message).set(0, "1"), std::invalid_argument);
  EXPECT_THROW(FieldEditor(field("short_text"), &message).set(0, "longer"), std::length_error);
  EXPECT_THROW(FieldEditor(field("short_wide"), &message).set(0, "longer"), std::length_error);
  EXPECT_THROW(FieldEditor(field("wide"), &message).set(0, "\xff"), std::invalid_argument);
  EXPECT_THROW(FieldEditor(field("few_bytes"), &message).resize(4), std::length_error);
  EXPECT_EQ(message, Everything());
}

TEST(FieldAccessTest, WideTextsAreUtf8Outside) {
  Everything message;
  FieldEditor(field("wide"), &message).set(0, "ä管😀");
  EXPECT_EQ(message.wide, u"ä管😀");
  EXPECT_EQ(FieldView(field("wide"), &message).text(), "ä管😀");
  message.wide = {0xD83D, u'x', 0xDE00};
  EXPECT_EQ(FieldView(field("wide"), &message).text(), "\uFFFDx\uFFFD");
}

std::vector<std::byte> serialized(const MessageType& type, const void* message) {
  std::vector<std::byte> bytes(type.serialized_size(message));
  bytes.resize(type.serialize(message, bytes));
  return bytes;
}

TEST(FieldAccessTest, AnyMessageSurvivesARoundTrip) {
  for (const auto* const type : testing::all_types()) {
    const bool holds = rc::check(std::string(type->name), [type] {
      const auto message = (*rc::gen::noShrink(testing::any_message(*type))).message;
      const auto bytes = serialized(*type, message.get());
      RC_ASSERT(!bytes.empty());
      RC_ASSERT(bytes.size() == type->serialized_size(message.get()));
      const auto copy = type->create();
      RC_ASSERT(type->deserialize(bytes, copy.get()));
      RC_ASSERT(serialized(*type, copy.get()) == bytes);
    });
    EXPECT_TRUE(holds) << type->name;
  }
}

}  // namespace
}  // namespace pipescout
