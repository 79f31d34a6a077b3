// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/thermal_image.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

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

TEST(ThermalImageReader, LeavesCountsWhereTheyAre) {
  const auto message = image("mono16", 6, {1, 2, 3, 4, 0, 0, 5, 6, 7, 8, 0, 0});
  ThermalImageReader reader;
  const auto view = std::get<thermal::CountView>(reader.read(message));
  EXPECT_EQ(static_cast<const void*>(view.data), message.data.data());
  EXPECT_EQ(view(1, 0), 0x0403);
  EXPECT_EQ(view(0, 1), 0x0605);
}

TEST(ThermalImageReader, TurnsBytesOfTheOtherOrder) {
  auto message = image("16UC1", 4, {1, 2, 3, 4, 5, 6, 7, 8});
  message.is_bigendian = 1;
  ThermalImageReader reader;
  const auto view = std::get<thermal::CountView>(reader.read(message));
  EXPECT_EQ(view(0, 0), 0x0102);
  EXPECT_EQ(view(1, 1), 0x0708);
}

TEST(ThermalImageReader, RowsMayHaveAnOddLength) {
  const auto message = image("mono16", 5, {1, 2, 3, 4, 0, 5, 6, 7, 8, 0});
  ThermalImageReader reader;
  const auto view = std::get<thermal::CountView>(reader.read(message));
  EXPECT_EQ(view(1, 0), 0x0403);
  EXPECT_EQ(view(0, 1), 0x0605);
}

TEST(ThermalImageReader, ReadsTemperaturesAndGreyLevels) {
  const std::array<float, 4> celsius{1.5F, -2.0F, 300.0F, 20.0F};
  std::vector<std::uint8_t> bytes(sizeof(celsius));
  std::memcpy(bytes.data(), celsius.data(), bytes.size());
  const auto temperatures = image("32FC1", 8, bytes);
  ThermalImageReader reader;
  EXPECT_EQ(std::get<thermal::TemperatureView>(reader.read(temperatures))(0, 1), 300.0F);
  const auto grey = image("mono8", 3, {1, 2, 0, 3, 4, 0});
  EXPECT_EQ(std::get<thermal::GreyView>(reader.read(grey))(1, 1), 4);
}

TEST(ThermalImageReader, NamesWhatIsWrong) {
  ThermalImageReader reader;
  const auto read = [&](const sensor_msgs::msg::Image& message) { (void)reader.read(message); };
  const std::vector<std::uint8_t> data(8);
  EXPECT_THAT([&] { read(image("rgb8", 6, data)); },
              ThrowsMessage<std::invalid_argument>(
                  HasSubstr("encoding is 'rgb8', colours, from which no temperatures "
                            "can be read; it must be 32FC1")));
  EXPECT_THAT([&] { read(image("mono16", 3, data)); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("step is 3")));
  EXPECT_THAT([&] { read(image("32FC1", 8, data)); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("data has 8")));
  auto empty = image("mono16", 4, data);
  empty.height = 0;
  EXPECT_THAT([&] { read(empty); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("width and height are 2 x 0")));
}

}  // namespace
}  // namespace pipescout
