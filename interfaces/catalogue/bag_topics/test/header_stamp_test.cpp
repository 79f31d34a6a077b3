// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bag_topics/header_stamp.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <sensor_msgs/msg/imu.hpp>
#include <std_msgs/msg/string.hpp>
#include <vector>

namespace pipescout {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

TEST(HeaderStamp, OnlyTypesThatBeginWithAHeaderHaveOne) {
  EXPECT_TRUE(begins_with_header(&message_type<sensor_msgs::msg::Imu>()));
  EXPECT_FALSE(begins_with_header(&message_type<std_msgs::msg::String>()));
  EXPECT_FALSE(begins_with_header(nullptr));
}

TEST(HeaderStamp, IsReadInBothByteOrdersAndNotBeyondTheEnd) {
  const auto bytes = [](std::initializer_list<int> values) {
    std::vector<std::byte> result;
    for (const int value : values) {
      result.push_back(static_cast<std::byte>(value));
    }
    return result;
  };
  EXPECT_EQ(header_stamp(bytes({0, 1, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0})), 2 * kSecond + 3);
  EXPECT_EQ(header_stamp(bytes({0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 3})), 2 * kSecond + 3);
  EXPECT_EQ(header_stamp(bytes({0, 1, 0, 0, 2, 0, 0, 0, 3, 0, 0})), std::nullopt);
}

}  // namespace
}  // namespace pipescout
