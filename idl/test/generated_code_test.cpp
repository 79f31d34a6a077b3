// SPDX-License-Identifier: Apache-2.0
// What the generator makes of the definitions in test_msgs/.
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <string>
#include <test_msgs/action/count.hpp>
#include <test_msgs/msg/everything.hpp>
#include <test_msgs/msg/from_idl.hpp>
#include <test_msgs/msg/nothing.hpp>
#include <test_msgs/srv/sum.hpp>
#include <type_traits>
#include <vector>

#include "pipescout/idl/action_type.hpp"

namespace pipescout {
namespace {

using test_msgs::msg::Everything;
using test_msgs::msg::FromIdl;

static_assert(std::is_aggregate_v<Everything>);
static_assert(Everything::LARGEST == 255);
static_assert(Everything::SMALLEST == std::numeric_limits<std::int64_t>::min());
static_assert(Everything::THIRD == 1.0f / 3.0f);
static_assert(Everything::YES);
static_assert(Everything::LETTER == 'A');
static_assert(std::is_same_v<decltype(Everything::octet), std::uint8_t>);
static_assert(std::is_same_v<decltype(Everything::wide), std::u16string>);
static_assert(std::is_same_v<decltype(Everything::f64_array), std::array<double, 2>>);
static_assert(std::is_same_v<decltype(Everything::truths), std::vector<bool>>);
static_assert(std::is_same_v<decltype(Everything::few_texts), BoundedVector<std::string, 3>>);
static_assert(std::is_same_v<decltype(Everything::header), std_msgs::msg::Header>);
static_assert(FromIdl::WARN == 1);
static_assert(std::is_same_v<decltype(FromIdl::map), std::string>);
static_assert(std::is_same_v<decltype(FromIdl::matrix), std::array<double, 9>>);
static_assert(std::is_same_v<decltype(FromIdl::relative), test_msgs::msg::Inner>);

static_assert(ServiceTag<test_msgs::srv::Sum>);
static_assert(test_msgs::srv::Sum::Request::MOST == 8);
static_assert(ActionTag<test_msgs::action::Count>);
static_assert(std::is_same_v<test_msgs::action::Count::Goal, test_msgs::action::Count_Goal>);
static_assert(
    std::is_same_v<decltype(test_msgs::action::Count::Impl::SendGoalService::Request::goal_id),
                   unique_identifier_msgs::msg::UUID>);
static_assert(ActionType<test_msgs::action::Count>::action_name == "test_msgs/action/Count");

TEST(GeneratedCodeTest, Defaults) {
  const Everything message;
  EXPECT_FALSE(message.truth);
  EXPECT_EQ(message.f64, 0.0);
  EXPECT_EQ(message.i16_array, (std::array<std::int16_t, 3>{}));
  EXPECT_TRUE(message.truth_default);
  EXPECT_EQ(message.i8_default, -7);
  EXPECT_EQ(message.f32_default, 1.5f);
  EXPECT_EQ(message.f64_default, 1e-3);
  EXPECT_EQ(message.text_default, "it is");
  EXPECT_EQ(message.wide_default, u"größe");
  EXPECT_EQ(message.array_default, (std::array<std::int32_t, 3>{1, -2, 3}));
  EXPECT_EQ(message.texts_default, (std::vector<std::string>{"a", "b, c", "d"}));
  EXPECT_EQ(message.truths_default, (std::array<bool, 2>{true, false}));
  const FromIdl from_idl;
  EXPECT_EQ(from_idl.count, 2u);
  EXPECT_EQ(from_idl.numbers, (std::vector<std::int16_t>{1, 2}));
}

TEST(GeneratedCodeTest, TextConstants) {
  EXPECT_EQ(Everything::GREETING, "say \"hello\"");
  EXPECT_EQ(Everything::BARE, "two words");
  EXPECT_EQ(FromIdl::NAME, "name");
}

TEST(GeneratedCodeTest, DesignatedInitialisersNameSomeFields) {
  const Everything message{.i8 = 3, .text = "x", .few_bytes = {1, 2}};
  EXPECT_EQ(message.i8, 3);
  EXPECT_EQ(message.few_bytes, (std::vector<std::uint8_t>{1, 2}));
  EXPECT_NE(message, Everything());
}

TEST(GeneratedCodeTest, NamesOfAnAction) {
  EXPECT_EQ(message_type<test_msgs::action::Count::Impl::FeedbackMessage>().dds_name,
            "test_msgs::action::dds_::Count_FeedbackMessage_");
  EXPECT_EQ(message_type<test_msgs::action::Count_SendGoal_Request>().name,
            "test_msgs/action/Count_SendGoal_Request");
}

template <class T>
std::vector<std::byte> serialized(const T& message) {
  const auto& type = message_type<T>();
  std::vector<std::byte> bytes(type.serialized_size(&message));
  bytes.resize(type.serialize(&message, bytes));
  return bytes;
}

TEST(GeneratedCodeTest, BytesOfWideTextsAndBounds) {
  test_msgs::srv::Sum_Response response;
  response.message = std::string(16, 'x');
  EXPECT_EQ(serialized(response).size(), 4u + 8u + 4u + 17u);
  response.message += 'x';
  EXPECT_TRUE(serialized(response).empty());

  FromIdl message;
  message.wide = u"ab";
  const auto bytes = serialized(message);
  auto longer = message;
  longer.wide = u"abc";
  // rmw_fastrtps writes a character of a wide text as a wchar_t of Linux.
  EXPECT_GE(serialized(longer).size(), bytes.size() + 4);
}

TEST(GeneratedCodeTest, WhatExceedsABoundIsRefused) {
  const auto& type = message_type<test_msgs::srv::Sum_Response>();
  std::vector<std::byte> bytes(4 + 8 + 4 + 18);
  bytes[1] = std::byte{1};
  bytes[12] = std::byte{17};  // 16 characters and the NUL
  for (std::size_t i = 16; i < 32; ++i) {
    bytes[i] = std::byte{'x'};
  }
  test_msgs::srv::Sum_Response message;
  EXPECT_TRUE(type.deserialize(bytes, &message));
  EXPECT_EQ(message.message, std::string(16, 'x'));
  bytes[12] = std::byte{18};
  bytes[32] = std::byte{'x'};
  EXPECT_FALSE(type.deserialize(bytes, &message));
}

TEST(GeneratedCodeTest, ALongerSequenceThanItsBoundIsRefused) {
  // The bytes of one that has no bound are those of one that has.
  using rcl_interfaces::msg::IntegerRange;
  using rcl_interfaces::msg::ParameterDescriptor;
  const auto& type = message_type<ParameterDescriptor>();
  ParameterDescriptor message;
  message.integer_range = {IntegerRange{.from_value = 1, .to_value = 2, .step = 1}};
  auto bytes = serialized(message);
  ASSERT_TRUE(type.deserialize(bytes, &message));
  // Ahead of the three numbers, which are aligned to 8 bytes counted from behind the header.
  std::size_t length_at = bytes.size() - 24 - 4;
  if (bytes[length_at] == std::byte{0}) {
    length_at -= 4;
  }
  ASSERT_EQ(bytes[length_at], std::byte{1});
  bytes[length_at] = std::byte{2};
  bytes.resize(bytes.size() + 24);
  EXPECT_FALSE(type.deserialize(bytes, &message));
}

}  // namespace
}  // namespace pipescout
