// SPDX-License-Identifier: Apache-2.0
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <sensor_msgs/msg/image.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "dds_profile.hpp"
#include "dds_test_support.hpp"
#include "shared_payloads.hpp"
#include "wire_type.hpp"

namespace pipescout {
namespace {

namespace fs = std::filesystem;
namespace fastdds = eprosima::fastdds::dds;
using dds::PayloadReference;
using dds_test::local_options;
using dds_test::ReaderRecord;
using dds_test::WriterRecord;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::size_t kBytes = std::size_t{1} << 20U;

std::size_t blocks_in(const fs::path& folder) {
  const auto files = fs::directory_iterator(folder);
  return static_cast<std::size_t>(std::count_if(begin(files), end(files), [](const auto& file) {
    return file.path().filename().string().starts_with(dds::kPayloadPrefix);
  }));
}

TEST(PayloadReferenceTest, SurvivesTheWireAndIsNoMessage) {
  const PayloadReference reference{.participant = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12},
                                   .block = 7,
                                   .sequence = 99,
                                   .bytes = 5};
  std::array<std::byte, dds::kReferenceBytes> payload{};
  encode(reference, payload);
  EXPECT_EQ(dds::decode_reference(payload), reference);
  EXPECT_EQ(dds::decode_reference(std::span(payload).first(31)), std::nullopt);
  payload[0] = std::byte{0};  // CDR
  EXPECT_EQ(dds::decode_reference(payload), std::nullopt);
}

class SharedPayloadsTest : public ::testing::Test {
 protected:
  SharedPayloadsTest()
      : place_(fs::path(dds::kSharedMemoryFolder) /
               ("pipescout_test_" + std::to_string(getpid()))) {
    fs::create_directories(place_);
    folder_ = std::make_shared<dds::PayloadFolder>(dds::GuidPrefix{1, 2, 3},
                                                   std::make_shared<dds::Warnings>(), place_);
  }
  ~SharedPayloadsTest() override {
    std::error_code ignored;
    fs::remove_all(place_, ignored);
  }

  static std::optional<PayloadReference> store(dds::PayloadWriter& writer, std::uint8_t value,
                                               std::size_t bytes = kBytes,
                                               std::size_t readers = 1) {
    return writer.store(bytes, readers, [value](std::span<std::byte> data) {
      std::memset(data.data(), value, data.size());
      return true;
    });
  }
  /// Size and value; nothing when the message is gone.
  static std::optional<std::pair<std::size_t, std::uint8_t>> take(dds::PayloadReader& reader,
                                                                  const PayloadReference& wanted) {
    std::pair<std::size_t, std::uint8_t> taken;
    const bool there = reader.take(wanted, [&](std::span<const std::byte> data) {
      EXPECT_TRUE(std::all_of(data.begin(), data.end(),
                              [&](std::byte value) { return value == data.front(); }));
      taken = {data.size(), static_cast<std::uint8_t>(data.front())};
    });
    return there ? std::optional(taken) : std::nullopt;
  }

  fs::path place_;
  std::shared_ptr<dds::PayloadFolder> folder_;
};

TEST_F(SharedPayloadsTest, CarriesMessagesInOneBlockAsLongAsReadersKeepUp) {
  dds::PayloadWriter writer(folder_, 5);
  dds::PayloadReader reader(place_);
  for (std::uint8_t value = 1; value <= 20; ++value) {
    const auto stored = store(writer, value);
    ASSERT_TRUE(stored);
    EXPECT_EQ(take(reader, *stored), std::pair(kBytes, value));
  }
  EXPECT_EQ(blocks_in(place_), 1U);
}

TEST_F(SharedPayloadsTest, KeepsWhatTheHistoryKeeps) {
  dds::PayloadWriter writer(folder_, 3);
  dds::PayloadReader reader(place_);
  std::vector<PayloadReference> stored;
  for (std::uint8_t value = 1; value <= 10; ++value) {
    stored.push_back(store(writer, value).value());
  }
  EXPECT_EQ(blocks_in(place_), 4U);
  for (std::uint8_t value = 8; value <= 10; ++value) {
    EXPECT_EQ(take(reader, stored[value - 1U]), std::pair(kBytes, value));
  }
  EXPECT_EQ(take(reader, stored[1]), std::nullopt);
}

TEST_F(SharedPayloadsTest, ABlockIsFreeOnceAllReadersTookItsMessage) {
  dds::PayloadWriter writer(folder_, 9);
  dds::PayloadReader first(place_);
  dds::PayloadReader second(place_);
  const auto stored = store(writer, 1, kBytes, 2);
  EXPECT_TRUE(take(first, *stored));
  const auto meanwhile = store(writer, 2, kBytes, 2);
  EXPECT_NE(meanwhile->block, stored->block);
  EXPECT_TRUE(take(second, *stored));
  EXPECT_EQ(store(writer, 3, kBytes, 2)->block, stored->block);
}

TEST_F(SharedPayloadsTest, WhatIsOverwrittenWhileItIsReadIsLost) {
  dds::PayloadWriter writer(folder_, 1);
  dds::PayloadReader reader(place_);
  const auto stored = store(writer, 1);
  EXPECT_FALSE(reader.take(*stored, [&](std::span<const std::byte>) {
    const auto second = store(writer, 2);
    EXPECT_NE(second->block, stored->block);
    EXPECT_EQ(store(writer, 3)->block, stored->block);
  }));
}

TEST_F(SharedPayloadsTest, GrowsWithTheMessagesAndLeavesNothing) {
  dds::PayloadReader reader(place_);
  {
    dds::PayloadWriter writer(folder_, 2);
    for (const std::size_t bytes : {kBytes, 2 * kBytes, kBytes / 2, 4 * kBytes}) {
      const auto stored = store(writer, 9, bytes);
      EXPECT_EQ(take(reader, *stored), std::pair(bytes, std::uint8_t{9}));
    }
    EXPECT_EQ(blocks_in(place_), 1U);
  }
  EXPECT_EQ(blocks_in(place_), 0U);
}

TEST_F(SharedPayloadsTest, AMessageThatCannotBeWrittenIsNotThere) {
  dds::PayloadWriter writer(folder_, 2);
  EXPECT_FALSE(writer.store(kBytes, 1, [](std::span<std::byte>) { return false; }));
}

TEST_F(SharedPayloadsTest, RefusesReferencesToWhatIsNotThere) {
  dds::PayloadWriter writer(folder_, 2);
  dds::PayloadReader reader(place_);
  const auto stored = store(writer, 1);
  PayloadReference forged = *stored;
  forged.bytes = 0xFFFFFFFF;
  EXPECT_EQ(take(reader, forged), std::nullopt);
  forged = *stored;
  ++forged.sequence;
  EXPECT_EQ(take(reader, forged), std::nullopt);
  forged = *stored;
  ++forged.block;
  EXPECT_EQ(take(reader, forged), std::nullopt);
  forged = *stored;
  forged.participant[0] = 0x7F;
  EXPECT_EQ(take(reader, forged), std::nullopt);
  EXPECT_TRUE(take(reader, *stored));
}

TEST_F(SharedPayloadsTest, SaysThatThereIsNoRoom) {
  const auto warnings = std::make_shared<dds::Warnings>();
  dds::PayloadWriter writer(
      std::make_shared<dds::PayloadFolder>(dds::GuidPrefix{}, warnings, place_ / "missing"), 2);
  EXPECT_EQ(store(writer, 1), std::nullopt);
  EXPECT_EQ(store(writer, 1), std::nullopt);
  EXPECT_THAT(warnings->all(), SizeIs(1));
}

TEST_F(SharedPayloadsTest, TakesNoMoreThanHalfOfWhatIsFree) {
  const std::size_t too_much = fs::space(place_).available / 4 * 3;
  if (too_much > std::numeric_limits<std::uint32_t>::max()) {
    GTEST_SKIP() << "no message is as large as half of the " << fs::space(place_).available
                 << " bytes that are free in " << place_;
  }
  dds::PayloadWriter writer(folder_, 2);
  EXPECT_EQ(store(writer, 1, too_much), std::nullopt);
  EXPECT_THAT(folder_->warnings().all(), SizeIs(1));
}

TEST_F(SharedPayloadsTest, TheEndOfAWriterWaitsForItsReaders) {
  dds::PayloadWriter writer(folder_, 2);
  const auto stored = store(writer, 1);
  std::thread reading([&] {
    dds::PayloadReader reader(place_);
    EXPECT_TRUE(take(reader, *stored));
  });
  writer.await_readers(std::chrono::seconds(30));
  dds::PayloadReader late(place_);
  reading.join();
  EXPECT_EQ(store(writer, 2)->block, stored->block);
}

/// Two participants that share memory, and what one writes to the other.
class DdsPayloadTest : public ::testing::Test {
 protected:
  static sensor_msgs::msg::Image image(std::size_t bytes = kBytes) {
    sensor_msgs::msg::Image message;
    message.data.resize(bytes);
    for (std::size_t i = 0; i < bytes; ++i) {
      message.data[i] = static_cast<std::uint8_t>(i * 31 + i / 251);
    }
    return message;
  }
  static const sensor_msgs::msg::Image& received(const dds_test::ReceivedMessage& message) {
    return *static_cast<const sensor_msgs::msg::Image*>(message.message.get());
  }

  const WireTopic topic_{dds_test::text_topic("payload").name,
                         &message_type<sensor_msgs::msg::Image>()};
  std::unique_ptr<Transport> here_ = create_dds_transport(local_options());
  std::unique_ptr<Transport> there_ = create_dds_transport(local_options());
  WriterRecord told_;
  ReaderRecord heard_;
};

TEST_F(DdsPayloadTest, ALargeMessageTakesTheWayThroughSharedMemory) {
  auto writer = here_->create_writer(topic_, QoS::reliable(), told_);
  const auto reader = there_->create_reader(topic_, QoS::reliable(), heard_);
  ASSERT_TRUE(told_.await_matched(1));
  ASSERT_TRUE(heard_.await_matched(1));
  const std::size_t before = blocks_in(dds::kSharedMemoryFolder);
  const auto message = image();
  for (int i = 0; i < 20; ++i) {
    const SampleIdentity sent = writer->write(&message, {});
    ASSERT_TRUE(heard_.await_messages(static_cast<std::size_t>(i) + 1));
    EXPECT_EQ(heard_.message(static_cast<std::size_t>(i)).info.identity, sent);
  }
  EXPECT_TRUE(received(heard_.message(19)).data == message.data);
  EXPECT_EQ(blocks_in(dds::kSharedMemoryFolder), before + 1);
  EXPECT_THAT(here_->warnings(), IsEmpty());
  writer.reset();
  EXPECT_EQ(blocks_in(dds::kSharedMemoryFolder), before);
}

TEST_F(DdsPayloadTest, SmallMessagesAndThoseThatAreKeptForLateReadersDoNot) {
  const WireTopic kept{topic_.name + "_kept", topic_.type};
  const auto writer = here_->create_writer(topic_, QoS::reliable(), told_);
  const auto reader = there_->create_reader(topic_, QoS::reliable(), heard_);
  WriterRecord kept_told;
  const auto kept_writer = here_->create_writer(kept, QoS::latched(), kept_told);
  ASSERT_TRUE(told_.await_matched(1));
  ASSERT_TRUE(heard_.await_matched(1));
  const std::size_t before = blocks_in(dds::kSharedMemoryFolder);
  const auto small = image(1000);
  writer->write(&small, {});
  ASSERT_TRUE(heard_.await_messages(1));
  const auto large = image();
  kept_writer->write(&large, {});
  ReaderRecord late;
  const auto late_reader = there_->create_reader(kept, QoS::latched(), late);
  ASSERT_TRUE(late.await_messages(1));
  EXPECT_TRUE(received(late.message(0)).data == large.data);
  EXPECT_EQ(blocks_in(dds::kSharedMemoryFolder), before);
}

/// A reader in a participant that knows nothing of our memory, as those of ROS 2.
class ForeignReader : private fastdds::DataReaderListener {
 public:
  explicit ForeignReader(const WireTopic& topic) : type_(*topic.type) {
    auto* factory = fastdds::DomainParticipantFactory::get_instance();
    fastdds::DomainParticipantQos qos = factory->get_default_participant_qos();
    qos.transport().use_builtin_transports = false;
    const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList.emplace_back("127.0.0.1");  // where ours are heard
    qos.transport().user_transports.push_back(udp);
    participant_ = factory->create_participant(local_options().domain_id, qos);
    fastdds::TypeSupport(new dds::WireType(topic.type->dds_name)).register_type(participant_);
    fastdds::DataReaderQos reader_qos;
    reader_qos.reliability().kind = fastdds::RELIABLE_RELIABILITY_QOS;
    participant_->create_subscriber(fastdds::SUBSCRIBER_QOS_DEFAULT)
        ->create_datareader(
            participant_->create_topic(topic.name, std::string(topic.type->dds_name),
                                       fastdds::TOPIC_QOS_DEFAULT),
            reader_qos, this);
  }
  ForeignReader(const ForeignReader&) = delete;
  ForeignReader& operator=(const ForeignReader&) = delete;
  ~ForeignReader() override {
    participant_->delete_contained_entities();
    fastdds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  ReaderRecord heard;

 private:
  void on_data_available(fastdds::DataReader* reader) override {
    dds::PayloadReader nowhere("/nowhere");
    dds::IncomingSample sample{.type = type_, .payloads = nowhere};
    fastdds::SampleInfo info;
    while (reader->take_next_sample(&sample, &info) ==
           eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
      if (sample.lost || sample.malformed) {
        heard.on_malformed_sample({});
      } else if (info.valid_data) {
        heard.on_remote_message(sample.message, {});
      }
    }
  }

  const MessageType& type_;
  fastdds::DomainParticipant* participant_ = nullptr;
};

TEST_F(DdsPayloadTest, AReaderThatKnowsNothingOfOurMemoryGetsTheMessageItself) {
  const auto writer = here_->create_writer(topic_, QoS::reliable(), told_);
  const auto reader = there_->create_reader(topic_, QoS::reliable(), heard_);
  const std::size_t before = blocks_in(dds::kSharedMemoryFolder);
  const auto message = image();
  {
    ForeignReader foreign(topic_);
    ASSERT_TRUE(told_.await_matched(2));
    ASSERT_TRUE(heard_.await_matched(1));
    writer->write(&message, {});
    ASSERT_TRUE(foreign.heard.await_messages(1));
    EXPECT_TRUE(received(foreign.heard.message(0)).data == message.data);
    ASSERT_TRUE(heard_.await_messages(1));
    EXPECT_EQ(foreign.heard.malformed, 0);
    EXPECT_EQ(blocks_in(dds::kSharedMemoryFolder), before);
  }
  ASSERT_TRUE(told_.await_matched(1));
  writer->write(&message, {});
  ASSERT_TRUE(heard_.await_messages(2));
  EXPECT_TRUE(received(heard_.message(1)).data == message.data);
  EXPECT_EQ(blocks_in(dds::kSharedMemoryFolder), before + 1);
}

}  // namespace
}  // namespace pipescout
