// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/grey_image.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pipescout {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

sensor_msgs::msg::Image image(const std::string& encoding, std::uint32_t step,
                              std::vector<std::uint8_t> data) {
  sensor_msgs::msg::Image message;
  message.width = 2;
  message.height = 2;
  message.encoding = encoding;
  message.step = step;
  message.data = std::move(data);
  return message;
}

TEST(GreyImageReader, LeavesGreyWhereItIs) {
  const auto message = image("mono8", 3, {1, 2, 0, 3, 4, 0});
  GreyImageReader reader;
  const auto view = reader.read(message);
  EXPECT_EQ(view.pixels, message.data.data());
  EXPECT_EQ(view.row(1)[1], 4);
}

TEST(GreyImageReader, KnowsTheOrderOfTheColours) {
  GreyImageReader reader;
  const std::vector<std::uint8_t> data{255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
  const auto rgb_message = image("rgb8", 6, data);
  const auto rgb = reader.read(rgb_message);
  EXPECT_EQ(rgb.row(0)[0], 77);
  EXPECT_EQ(rgb.row(0)[1], 149);
  EXPECT_EQ(rgb.row(1)[0], 29);
  EXPECT_EQ(rgb.row(1)[1], 255);
  const auto bgr_message = image("bgr8", 6, data);
  const auto bgr = reader.read(bgr_message);
  EXPECT_EQ(bgr.row(0)[0], 29);
  EXPECT_EQ(bgr.row(1)[0], 77);
}

TEST(GreyImageReader, NamesWhatIsWrong) {
  GreyImageReader reader;
  EXPECT_THAT([&] { (void)reader.read(image("yuv422", 4, std::vector<std::uint8_t>(8))); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("yuv422")));
  EXPECT_THAT(
      [&] {
        (void)reader.read(image("mono8", 1, {1, 2, 3, 4}));
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("step is 1")));
  EXPECT_THAT(
      [&] {
        (void)reader.read(image("mono8", 2, {1, 2, 3}));
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("data has 3")));
  EXPECT_THAT([&] { (void)reader.read(sensor_msgs::msg::Image()); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("encoding")));
}

}  // namespace
}  // namespace pipescout
