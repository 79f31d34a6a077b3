// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <sensor_msgs/msg/image.hpp>
#include <string>
#include <utility>

#include "dds_profile.hpp"
#include "dds_test_support.hpp"

namespace pipescout::dds_test {
namespace {

DdsOptions options_for(NetworkProfile::Kind kind) {
  auto options = local_options();
  options.network.kind = kind;
  return options;
}

// What is kept for late comers does not go by reference, so it is sent as between machines.
constexpr QoS kReliable = QoS::latched(1);
constexpr QoS kBestEffort{
    .depth = 1, .reliability = Reliability::kBestEffort, .durability = Durability::kTransientLocal};

/// An image larger than a datagram, both ways, where each end has another profile.
TEST(DdsNetworkProfile, EndsOfDifferentProfilesUnderstandEachOther) {
  const auto wire = create_dds_transport(options_for(NetworkProfile::Kind::kWire));
  const auto wifi = create_dds_transport(options_for(NetworkProfile::Kind::kWifi));
  sensor_msgs::msg::Image image;
  image.data.assign(300'000, 7);
  int direction = 0;
  for (const auto& [from, to] : {std::pair(wire.get(), wifi.get()), {wifi.get(), wire.get()}}) {
    const WireTopic topic{"rt/image_" + std::to_string(direction++) + std::to_string(getpid()),
                          &message_type<sensor_msgs::msg::Image>()};
    WriterRecord writer_record;
    ReaderRecord reader_record;
    const auto writer = from->create_writer(topic, kReliable, writer_record);
    const auto reader = to->create_reader(topic, kReliable, reader_record);
    ASSERT_TRUE(writer_record.await_matched(1));
    ASSERT_TRUE(reader_record.await_matched(1));
    writer->write(&image, {});
    ASSERT_TRUE(reader_record.await_messages(1));
    EXPECT_EQ(static_cast<const sensor_msgs::msg::Image*>(reader_record.message(0).message.get())
                  ->data.size(),
              image.data.size());
  }
}

/// Best effort images wait for their turn at the rate of the profile; a reliable message behind
/// them does not wait for it.
TEST(DdsNetworkProfile, ReliableMessagesOvertakeBestEffortImages) {
  auto slow = options_for(NetworkProfile::Kind::kWifi);
  slow.network.rate = 0.5;
  const auto robot = create_dds_transport(slow);
  const auto station = create_dds_transport(options_for(NetworkProfile::Kind::kWire));
  const WireTopic images{"rt/images_" + std::to_string(getpid()),
                         &message_type<sensor_msgs::msg::Image>()};
  WriterRecord image_writer_record;
  ReaderRecord image_record;
  WriterRecord event_writer_record;
  ReaderRecord event_record;
  const auto image_writer = robot->create_writer(images, kBestEffort, image_writer_record);
  const auto image_reader = station->create_reader(images, kBestEffort, image_record);
  const auto event_writer =
      robot->create_writer(text_topic("events"), QoS::reliable(10), event_writer_record);
  const auto event_reader =
      station->create_reader(text_topic("events"), QoS::reliable(10), event_record);
  ASSERT_TRUE(image_writer_record.await_matched(1));
  ASSERT_TRUE(event_writer_record.await_matched(1));
  ASSERT_TRUE(image_record.await_matched(1));
  ASSERT_TRUE(event_record.await_matched(1));
  sensor_msgs::msg::Image image;
  image.data.assign(500'000, 7);  // 8 s at that rate
  image_writer->write(&image, {});
  const auto event = make_text("found");
  event_writer->write(&event, {});
  ASSERT_TRUE(event_record.await_messages(1));
  EXPECT_TRUE(image_record.monitor.copy(image_record.messages).empty());
  // Of the images that wait only the newest is sent.
  image.data.assign(10'000, 8);
  image_writer->write(&image, {});
  ASSERT_TRUE(image_record.await_messages(1));
  EXPECT_EQ(static_cast<const sensor_msgs::msg::Image*>(image_record.message(0).message.get())
                ->data.size(),
            10'000U);
}

}  // namespace
}  // namespace pipescout::dds_test
