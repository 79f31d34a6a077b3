// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <optional>
#include <sensor_msgs/msg/image.hpp>
#include <span>
#include <stdexcept>
#include <thread>

#include "dds_profile.hpp"
#include "dds_test_support.hpp"
#include "participant.hpp"
#include "pipescout/runtime/serialized_message.hpp"
#include "rtps_conversions.hpp"

namespace pipescout {
namespace {

using dds_test::local_options;
using dds_test::make_text;
using dds_test::ReaderRecord;
using dds_test::ReceivedMessage;
using dds_test::text_topic;
using dds_test::WriterRecord;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Two participants that meet as two processes do: shared memory between them, nothing handed over
// in process.
class DdsTransportTest : public ::testing::Test {
 protected:
  std::unique_ptr<Transport> here_ = create_dds_transport(local_options());
  std::unique_ptr<Transport> there_ = create_dds_transport(local_options());
};

TEST_F(DdsTransportTest, CarriesAMessageWithItsIdentityAndTime) {
  ReaderRecord heard;
  WriterRecord told;
  const auto reader = there_->create_reader(text_topic("one"), QoS::reliable(), heard);
  const auto writer = here_->create_writer(text_topic("one"), QoS::reliable(), told);
  ASSERT_TRUE(told.await_matched(1));
  ASSERT_TRUE(heard.await_matched(1));
  const Time before = std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now());
  const auto message = make_text("hello");
  const SampleIdentity sent = writer->write(&message, {});

  ASSERT_TRUE(heard.await_messages(1));
  EXPECT_EQ(heard.text(0), "hello");
  const MessageInfo info = heard.message(0).info;
  EXPECT_EQ(sent.writer, writer->gid());
  EXPECT_GT(sent.sequence_number, 0);
  EXPECT_EQ(info.identity, sent);
  EXPECT_EQ(info.related, SampleIdentity{});
  EXPECT_FALSE(info.from_this_process);
  // The wire counts in 2^-32 s.
  EXPECT_GE(info.source_time, before - std::chrono::microseconds(1));
}

TEST_F(DdsTransportTest, EndpointsOfBytesAndOfObjectsMeetAndShareATopic) {
  const WireTopic objects = text_topic("bytes");
  const WireTopic bytes{objects.name, &serialized_type(objects.type->name)};
  ReaderRecord heard_objects;
  ReaderRecord heard_bytes;
  WriterRecord told_of_objects;
  WriterRecord told_of_bytes;
  const auto object_reader = there_->create_reader(objects, QoS::reliable(), heard_objects);
  const auto byte_reader = there_->create_reader(bytes, QoS::reliable(), heard_bytes);
  const auto object_writer = here_->create_writer(objects, QoS::reliable(), told_of_objects);
  const auto byte_writer = here_->create_writer(bytes, QoS::reliable(), told_of_bytes);
  ASSERT_TRUE(told_of_objects.await_matched(2));
  ASSERT_TRUE(told_of_bytes.await_matched(2));
  ASSERT_TRUE(heard_objects.await_matched(2));
  ASSERT_TRUE(heard_bytes.await_matched(2));

  const auto hello = make_text("hello");
  object_writer->write(&hello, {});
  ASSERT_TRUE(heard_bytes.await_messages(1));
  ASSERT_TRUE(heard_objects.await_messages(1));
  EXPECT_EQ(heard_objects.text(0), "hello");
  const auto received =
      std::static_pointer_cast<const SerializedMessage>(heard_bytes.message(0).message);
  const auto expected = serialize(*objects.type, &hello);
  EXPECT_TRUE(
      std::equal(expected->bytes().begin(), expected->bytes().end(), received->bytes().begin()));
  EXPECT_GE(heard_bytes.message(0).info.reception_time,
            heard_bytes.message(0).info.source_time - std::chrono::microseconds(1));

  byte_writer->write(received.get(), {});
  ASSERT_TRUE(heard_objects.await_messages(2));
  ASSERT_TRUE(heard_bytes.await_messages(2));
  EXPECT_EQ(heard_objects.text(1), "hello");
  EXPECT_EQ(heard_objects.malformed + heard_bytes.malformed, 0);
}

TEST_F(DdsTransportTest, BytesOfATypeThatNobodyKnowsArriveAsTheyWereSent) {
  // Large enough to go through shared memory.
  const WireTopic topic{text_topic("unheard").name, &serialized_type("nobody_msgs/msg/Unheard")};
  ReaderRecord heard;
  WriterRecord told;
  const auto reader = there_->create_reader(topic, QoS::reliable(), heard);
  const auto writer = here_->create_writer(topic, QoS::reliable(), told);
  ASSERT_TRUE(told.await_matched(1));
  ASSERT_TRUE(heard.await_matched(1));
  SerializedMessage message(std::size_t{1} << 20U);
  for (std::size_t i = 0; i < message.bytes().size(); ++i) {
    message.bytes()[i] = static_cast<std::byte>(i * 31 + i / 251);
  }
  message.bytes()[0] = std::byte{0};  // big-endian: it goes through as it is
  message.bytes()[1] = std::byte{0};
  writer->write(&message, {});
  ASSERT_TRUE(heard.await_messages(1));
  const auto received = std::static_pointer_cast<const SerializedMessage>(heard.message(0).message);
  ASSERT_EQ(received->bytes().size(), message.bytes().size());
  EXPECT_TRUE(
      std::equal(message.bytes().begin(), message.bytes().end(), received->bytes().begin()));
}

TEST_F(DdsTransportTest, ReadsEveryRemoteMessageThatComesAmongItsOwn) {
  constexpr std::size_t kMessages = 3000;
  const WireTopic topic = text_topic("own_and_remote");
  QoS qos = QoS::reliable();
  qos.depth = 2 * kMessages;
  ReaderRecord heard;
  WriterRecord told_here;
  WriterRecord told_there;
  const auto reader = here_->create_reader(topic, qos, heard);
  const auto own = here_->create_writer(topic, qos, told_here);
  const auto remote = there_->create_writer(topic, qos, told_there);
  ASSERT_TRUE(told_there.await_matched(1));
  ASSERT_TRUE(heard.await_matched(1));
  const auto message = make_text("hello");
  std::thread others([&] {
    for (std::size_t i = 0; i < kMessages; ++i) {
      own->write(&message, {});
    }
  });
  for (std::size_t i = 0; i < kMessages; ++i) {
    remote->write(&message, {});
  }
  others.join();
  ASSERT_TRUE(heard.await_messages(kMessages));
  for (const ReceivedMessage& received : heard.monitor.copy(heard.messages)) {
    ASSERT_NE(received.message, nullptr);
    EXPECT_EQ(*std::static_pointer_cast<const std_msgs::msg::String>(received.message), message);
  }
}

TEST_F(DdsTransportTest, CarriesBestEffortMessages) {
  ReaderRecord heard;
  WriterRecord told;
  const auto reader = there_->create_reader(text_topic("best_effort"), QoS::sensor_data(), heard);
  const auto writer = here_->create_writer(text_topic("best_effort"), QoS::sensor_data(), told);
  ASSERT_TRUE(told.await_matched(1));
  ASSERT_TRUE(heard.await_matched(1));
  const auto message = make_text("hello");
  writer->write(&message, {});
  ASSERT_TRUE(heard.await_messages(1));
  EXPECT_EQ(heard.text(0), "hello");
}

TEST_F(DdsTransportTest, CarriesAMessageLargerThanTheSharedMemory) {
  // Kept for late readers, so it does not go by reference.
  DdsOptions small = local_options();
  small.shared_memory_segment_bytes = std::size_t{512} * 1024;
  const auto sender = create_dds_transport(small);
  const WireTopic topic{text_topic("large").name, &message_type<sensor_msgs::msg::Image>()};
  ReaderRecord heard;
  WriterRecord told;
  const auto reader = there_->create_reader(topic, QoS::latched(1), heard);
  const auto writer = sender->create_writer(topic, QoS::latched(1), told);
  ASSERT_TRUE(told.await_matched(1));
  ASSERT_TRUE(heard.await_matched(1));
  sensor_msgs::msg::Image image;
  image.data.resize(std::size_t{2} * 1024 * 1024);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    image.data[i] = static_cast<std::uint8_t>(i * 31 + i / 251);
  }
  EXPECT_GT(writer->write(&image, {}).sequence_number, 0);

  ASSERT_TRUE(heard.await_messages(1));
  const auto kept = heard.message(0).message;
  const auto& received = *static_cast<const sensor_msgs::msg::Image*>(kept.get());
  EXPECT_TRUE(received.data == image.data);
}

TEST_F(DdsTransportTest, LateJoinerGetsWhatTheWriterKeeps) {
  WriterRecord told;
  const auto writer = here_->create_writer(text_topic("kept"), QoS::latched(2), told);
  for (const char* text : {"first", "second", "third"}) {
    const auto message = make_text(text);
    EXPECT_GT(writer->write(&message, {}).sequence_number, 0);
  }
  ReaderRecord heard;
  const auto reader = there_->create_reader(text_topic("kept"), QoS::latched(2), heard);
  ASSERT_TRUE(heard.await_messages(2));
  EXPECT_EQ(heard.text(0), "second");
  EXPECT_EQ(heard.text(1), "third");
}

TEST_F(DdsTransportTest, BothSidesLearnOfIncompatibleQos) {
  WriterRecord told;
  const auto writer = here_->create_writer(text_topic("apart"), QoS::sensor_data(), told);
  ReaderRecord heard;
  const auto reader = there_->create_reader(text_topic("apart"), QoS::reliable(), heard);
  EXPECT_TRUE(told.monitor.await([&] { return !told.incompatible.empty(); }));
  EXPECT_TRUE(heard.monitor.await([&] { return !heard.incompatible.empty(); }));
  EXPECT_THAT(told.monitor.copy(told.incompatible), ElementsAre(QosPolicy::kReliability));
  EXPECT_THAT(heard.monitor.copy(heard.incompatible), ElementsAre(QosPolicy::kReliability));
  EXPECT_EQ(writer->matched_remote_readers(), 0);
  EXPECT_EQ(reader->matched_remote_writers(), 0);

  // One that comes when the other is known already.
  ReaderRecord late_heard;
  const auto late = there_->create_reader(text_topic("apart"), QoS::latched(), late_heard);
  EXPECT_TRUE(late_heard.monitor.await([&] { return !late_heard.incompatible.empty(); }));
}

TEST_F(DdsTransportTest, CountsMatchesUpAndDown) {
  WriterRecord told;
  const auto writer = here_->create_writer(text_topic("count"), QoS::reliable(), told);
  ReaderRecord first_heard;
  ReaderRecord second_heard;
  auto first = there_->create_reader(text_topic("count"), QoS::reliable(), first_heard);
  auto second = there_->create_reader(text_topic("count"), QoS::reliable(), second_heard);
  ASSERT_TRUE(told.await_matched(2));
  ASSERT_TRUE(first_heard.await_matched(1));
  EXPECT_EQ(writer->matched_remote_readers(), 2);
  EXPECT_TRUE(writer->is_matched(first->gid()));
  EXPECT_TRUE(writer->is_matched(second->gid()));
  EXPECT_FALSE(writer->is_matched(writer->gid()));
  EXPECT_EQ(first->matched_remote_writers(), 1);
  EXPECT_TRUE(first->is_matched(writer->gid()));

  const Gid gone = first->gid();
  first.reset();
  ASSERT_TRUE(told.await_matched(1));
  EXPECT_FALSE(writer->is_matched(gone));
  second.reset();
  ASSERT_TRUE(told.await_matched(0));
  EXPECT_EQ(writer->matched_remote_readers(), 0);
}

TEST_F(DdsTransportTest, EndpointsOfThisProcessDoNotCountAndAreNotHeard) {
  const WireTopic topic = text_topic("own");
  ReaderRecord own_heard;
  WriterRecord own_told;
  const auto own_reader = here_->create_reader(topic, QoS::reliable(), own_heard);
  const auto own_writer = here_->create_writer(topic, QoS::reliable(), own_told);
  WriterRecord told;
  const auto writer = there_->create_writer(topic, QoS::reliable(), told);
  ASSERT_TRUE(own_heard.await_matched(1));
  ASSERT_TRUE(told.await_matched(1));
  EXPECT_EQ(own_writer->matched_remote_readers(), 0);
  EXPECT_FALSE(own_writer->is_matched(own_reader->gid()));
  EXPECT_FALSE(own_reader->is_matched(own_writer->gid()));

  const auto own = make_text("own");
  const auto remote = make_text("remote");
  for (int i = 0; i < 3; ++i) {
    EXPECT_GT(own_writer->write(&own, {}).sequence_number, 0);
    EXPECT_GT(writer->write(&remote, {}).sequence_number, 0);
  }
  ASSERT_TRUE(own_heard.await_messages(3));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(own_heard.text(i), "remote");
  }
  EXPECT_TRUE(own_told.monitor.copy(own_told.incompatible).empty());
}

TEST_F(DdsTransportTest, LivelinessFollowsTheParticipant) {
  QoS qos = QoS::reliable();
  qos.liveliness_lease = std::chrono::seconds(1);
  ReaderRecord heard;
  const auto reader = here_->create_reader(text_topic("alive"), qos, heard);
  WriterRecord told;
  auto writer = there_->create_writer(text_topic("alive"), qos, told);
  ASSERT_TRUE(heard.await_liveliness(1, 0));
  writer.reset();
  there_.reset();
  EXPECT_TRUE(heard.await_liveliness(0, 0));
  EXPECT_TRUE(heard.await_matched(0));
}

TEST_F(DdsTransportTest, AWriterWithoutLeaseIsAliveWhileItIsMatched) {
  ReaderRecord heard;
  const auto reader = here_->create_reader(text_topic("no_lease"), QoS::reliable(), heard);
  WriterRecord told;
  auto writer = there_->create_writer(text_topic("no_lease"), QoS::reliable(), told);
  ASSERT_TRUE(heard.await_liveliness(1, 0));
  writer.reset();
  EXPECT_TRUE(heard.await_liveliness(0, 0));
}

TEST_F(DdsTransportTest, AManualLeaseExpiresAndIsRenewed) {
  QoS qos = QoS::reliable();
  qos.liveliness = Liveliness::kManualByTopic;
  qos.liveliness_lease = std::chrono::milliseconds(200);
  const WireTopic topic = text_topic("manual");
  ReaderRecord heard;
  const auto reader = here_->create_reader(topic, qos, heard);
  WriterRecord told;
  const auto writer = there_->create_writer(topic, qos, told);
  ASSERT_TRUE(told.await_matched(1));
  ASSERT_TRUE(heard.await_matched(1));
  writer->assert_liveliness();
  ASSERT_TRUE(heard.await_liveliness(0, 1));
  const auto alive_again = [&, seen = heard.monitor.copy(heard.liveliness).size()] {
    return std::any_of(heard.liveliness.begin() + static_cast<std::ptrdiff_t>(seen),
                       heard.liveliness.end(),
                       [](const LivelinessChange& change) { return change.alive == 1; });
  };
  writer->assert_liveliness();
  EXPECT_TRUE(heard.monitor.await(alive_again));
  EXPECT_TRUE(heard.await_liveliness(0, 1));
}

TEST_F(DdsTransportTest, LivelinessLeavesOutTheWritersOfThisProcess) {
  QoS qos = QoS::reliable();
  qos.liveliness_lease = std::chrono::seconds(1);
  ReaderRecord heard;
  const auto reader = here_->create_reader(text_topic("own_alive"), qos, heard);
  WriterRecord own_told;
  const auto own = here_->create_writer(text_topic("own_alive"), qos, own_told);
  WriterRecord told;
  auto writer = there_->create_writer(text_topic("own_alive"), qos, told);
  ASSERT_TRUE(heard.await_liveliness(1, 0));
  writer.reset();
  EXPECT_TRUE(heard.await_liveliness(0, 0));
  for (const LivelinessChange& change : heard.monitor.copy(heard.liveliness)) {
    EXPECT_LE(change.alive, 1);
  }
}

TEST_F(DdsTransportTest, CarriesTheIdentitiesOfAService) {
  const auto request_topic = text_topic("add_request");
  const auto reply_topic = text_topic("add_reply");
  ReaderRecord requests;
  ReaderRecord replies;
  WriterRecord request_told;
  WriterRecord reply_told;
  const auto server_reader = there_->create_reader(request_topic, QoS::services(), requests);
  const auto server_writer = there_->create_writer(reply_topic, QoS::services(), reply_told);
  const auto client_reader = here_->create_reader(reply_topic, QoS::services(), replies);
  const auto client_writer = here_->create_writer(request_topic, QoS::services(), request_told);
  ASSERT_TRUE(request_told.await_matched(1));
  ASSERT_TRUE(reply_told.await_matched(1));
  ASSERT_TRUE(requests.await_matched(1));
  ASSERT_TRUE(replies.await_matched(1));

  // The client names the reader that waits for the reply, as rmw_fastrtps does.
  const auto request = make_text("request");
  const SampleIdentity sent = client_writer->write(&request, {.writer = client_reader->gid()});
  ASSERT_TRUE(requests.await_messages(1));
  const MessageInfo asked = requests.message(0).info;
  EXPECT_EQ(asked.identity, sent);
  EXPECT_EQ(asked.related, (SampleIdentity{.writer = client_reader->gid()}));

  const SampleIdentity answers{asked.related.writer, asked.identity.sequence_number};
  EXPECT_TRUE(server_writer->is_matched(answers.writer));
  const auto reply = make_text("reply");
  server_writer->write(&reply, answers);
  ASSERT_TRUE(replies.await_messages(1));
  EXPECT_EQ(replies.message(0).info.related, answers);

  // A sequence number that needs more than 32 bits.
  const SampleIdentity large{client_writer->gid(), 0x1'2345'6789};
  server_writer->write(&reply, large);
  ASSERT_TRUE(replies.await_messages(2));
  EXPECT_EQ(replies.message(1).info.related, large);
}

TEST_F(DdsTransportTest, ReportsTheRemoteGraph) {
  dds_test::Monitor monitor;
  int changes = 0;
  here_->on_graph_changed([&] { monitor.change([&] { ++changes; }); });
  DdsOptions options = local_options();
  options.name = "talker_host";
  options.enclave = "/inspection/crawler";
  auto other = create_dds_transport(options);
  QoS qos = QoS::latched(7);
  qos.deadline = std::chrono::milliseconds(1500);
  qos.liveliness = Liveliness::kManualByTopic;
  qos.liveliness_lease = std::chrono::seconds(3);
  qos.lifespan = std::chrono::seconds(20);
  WriterRecord told;
  auto writer = other->create_writer(text_topic("graph"), qos, told);
  WriterRecord own_told;
  const auto own = here_->create_writer(text_topic("graph"), QoS::reliable(), own_told);

  const auto find = [&]() -> std::optional<DiscoveredEndpoint> {
    for (const DiscoveredEndpoint& endpoint : here_->remote_endpoints()) {
      EXPECT_NE(endpoint.gid, own->gid());
      if (endpoint.gid == writer->gid()) {
        return endpoint;
      }
    }
    return std::nullopt;
  };
  ASSERT_TRUE(monitor.await([&] { return find().has_value(); }));
  const DiscoveredEndpoint found = *find();
  EXPECT_TRUE(found.is_writer);
  EXPECT_EQ(found.participant, other->participant());
  EXPECT_EQ(found.topic, text_topic("graph").name);
  EXPECT_EQ(found.type, "std_msgs::msg::dds_::String_");
  qos.depth = 0;
  EXPECT_EQ(found.qos, qos);

  const Gid gid = other->participant();
  const auto participants = here_->remote_participants();
  const auto participant =
      std::find_if(participants.begin(), participants.end(),
                   [&](const DiscoveredParticipant& one) { return one.gid == gid; });
  ASSERT_NE(participant, participants.end());
  EXPECT_EQ(participant->name, "talker_host");
  EXPECT_EQ(participant->enclave, "/inspection/crawler");

  // The participant goes when its last endpoint has gone, and takes all it had with it.
  writer.reset();
  other.reset();
  EXPECT_TRUE(monitor.await([&] {
    for (const DiscoveredParticipant& one : here_->remote_participants()) {
      if (one.gid == gid) {
        return false;
      }
    }
    return true;
  }));
  here_->on_graph_changed(nullptr);
  const int last = changes;
  there_.reset();
  EXPECT_EQ(changes, last);
}

// Says that it writes a string of 4 GB.
const MessageType& lying_type() {
  static const MessageType type = [] {
    MessageType lies = message_type<std_msgs::msg::String>();
    lies.serialize = [](const void* message, std::span<std::byte> buffer) -> std::size_t {
      const auto& text = static_cast<const std_msgs::msg::String*>(message)->data;
      if (text == "truth") {
        return message_type<std_msgs::msg::String>().serialize(message, buffer);
      }
      constexpr unsigned char kHostile[] = {0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff};
      std::memcpy(buffer.data(), kHostile, sizeof(kHostile));
      return sizeof(kHostile);
    };
    return lies;
  }();
  return type;
}

TEST_F(DdsTransportTest, DropsMalformedSamplesAndGoesOn) {
  ReaderRecord heard;
  WriterRecord told;
  const WireTopic topic = text_topic("malformed");
  const auto reader = there_->create_reader(topic, QoS::reliable(), heard);
  const auto writer = here_->create_writer({topic.name, &lying_type()}, QoS::reliable(), told);
  ASSERT_TRUE(told.await_matched(1));
  ASSERT_TRUE(heard.await_matched(1));
  for (const char* text : {"lie", "lie", "truth"}) {
    const auto message = make_text(text);
    writer->write(&message, {});
  }
  ASSERT_TRUE(heard.await_messages(1));
  EXPECT_EQ(heard.text(0), "truth");
  EXPECT_EQ(heard.monitor.copy(heard.malformed), 2);
}

TEST_F(DdsTransportTest, AMessageThatCannotBeSerialisedIsNotSent) {
  static const MessageType failing = [] {
    MessageType type = message_type<std_msgs::msg::String>();
    type.serialize = [](const void*, std::span<std::byte>) -> std::size_t { return 0; };
    return type;
  }();
  WriterRecord told;
  const auto writer =
      here_->create_writer({text_topic("failing").name, &failing}, QoS::reliable(), told);
  const auto message = make_text("never");
  EXPECT_EQ(writer->write(&message, {}).sequence_number, 0);
}

struct ThrowingReader : ReaderRecord {
  void on_remote_message(std::shared_ptr<const void> message, const MessageInfo& info) override {
    ReaderRecord::on_remote_message(std::move(message), info);
    throw std::runtime_error("from the test, on purpose");
  }
};

TEST_F(DdsTransportTest, AListenerThatThrowsEndsNothing) {
  ThrowingReader heard;
  WriterRecord told;
  const auto reader = there_->create_reader(text_topic("throws"), QoS::reliable(), heard);
  const auto writer = here_->create_writer(text_topic("throws"), QoS::reliable(), told);
  ASSERT_TRUE(told.await_matched(1));
  ASSERT_TRUE(heard.await_matched(1));
  const auto message = make_text("hello");
  writer->write(&message, {});
  writer->write(&message, {});
  EXPECT_TRUE(heard.await_messages(2));
}

// Fails when it is called after its reader's destruction.
struct GuardedReader : ReaderRecord {
  void on_remote_message(std::shared_ptr<const void> message, const MessageInfo& info) override {
    EXPECT_FALSE(destroyed.load());
    ReaderRecord::on_remote_message(std::move(message), info);
    EXPECT_FALSE(destroyed.load());
  }
  void on_remote_writers_changed(int matched) override {
    EXPECT_FALSE(destroyed.load());
    ReaderRecord::on_remote_writers_changed(matched);
  }
  std::atomic<bool> destroyed{false};
};

TEST_F(DdsTransportTest, NoCallFollowsTheDestructionOfAReader) {
  const WireTopic topic = text_topic("destroy");
  WriterRecord told;
  const auto writer = here_->create_writer(topic, QoS::reliable(), told);
  std::atomic<bool> stop{false};
  std::thread flood([&] {
    const auto message = make_text("flood");
    while (!stop) {
      writer->write(&message, {});
    }
  });
  std::vector<std::unique_ptr<GuardedReader>> listeners;
  for (int i = 0; i < 10; ++i) {
    auto& heard = *listeners.emplace_back(std::make_unique<GuardedReader>());
    auto reader = there_->create_reader(topic, QoS::reliable(), heard);
    EXPECT_TRUE(heard.await_messages(3));
    reader.reset();
    heard.destroyed = true;
  }
  stop = true;
  flood.join();
}

TEST_F(DdsTransportTest, EndpointsMayOutliveTheTransport) {
  ReaderRecord heard;
  WriterRecord told;
  const auto reader = there_->create_reader(text_topic("outlive"), QoS::reliable(), heard);
  const auto writer = here_->create_writer(text_topic("outlive"), QoS::reliable(), told);
  here_.reset();
  there_.reset();
  ASSERT_TRUE(told.await_matched(1));
  ASSERT_TRUE(heard.await_matched(1));
  const auto message = make_text("still here");
  writer->write(&message, {});
  EXPECT_TRUE(heard.await_messages(1));
}

TEST_F(DdsTransportTest, OneTopicHasOneTypeInAProcess) {
  WriterRecord told;
  const WireTopic topic = text_topic("typed");
  const WireTopic other{topic.name, &message_type<sensor_msgs::msg::Image>()};
  {
    const auto writer = here_->create_writer(topic, QoS::reliable(), told);
    const auto second = here_->create_writer(topic, QoS::reliable(), told);
    try {
      const auto wrong = here_->create_writer(other, QoS::reliable(), told);
      FAIL() << "no exception";
    } catch (const TransportError& error) {
      EXPECT_THAT(error.what(), HasSubstr(topic.name));
      EXPECT_THAT(error.what(), HasSubstr("sensor_msgs/msg/Image"));
      EXPECT_THAT(error.what(), HasSubstr("std_msgs/msg/String"));
    }
  }
  // Nobody uses it any more, so it may change.
  EXPECT_NO_THROW((void)here_->create_writer(other, QoS::reliable(), told));
}

TEST(DdsProfileTest, AnEndpointStartsFromTheProfileOfItsTopic) {
  const dds::Participant participant(local_options());
  const auto shared = eprosima::fastdds::dds::SHARED_OWNERSHIP_QOS;
  const auto exclusive = eprosima::fastdds::dds::EXCLUSIVE_OWNERSHIP_QOS;
  EXPECT_EQ(participant.writer_profile("rt/profiled").ownership().kind, exclusive);
  EXPECT_EQ(participant.reader_profile("rt/profiled").ownership().kind, exclusive);
  EXPECT_EQ(participant.writer_profile("rt/another").ownership().kind, shared);
  EXPECT_EQ(participant.reader_profile("rt/another").ownership().kind, shared);
}

TEST(DdsProfileTest, AWriterPublishesAsItsProfileSays) {
  const dds::Participant participant(local_options());
  const auto profiled = dds::writer_qos(QoS::reliable(), participant.writer_profile("rt/profiled"));
  EXPECT_EQ(profiled.publish_mode().kind, eprosima::fastdds::dds::ASYNCHRONOUS_PUBLISH_MODE);
  EXPECT_EQ(profiled.throughput_controller().bytesPerPeriod, 65536U);
  EXPECT_EQ(profiled.throughput_controller().periodMillisecs, 1U);
  const auto another = dds::writer_qos(QoS::reliable(), participant.writer_profile("rt/another"));
  EXPECT_EQ(another.publish_mode().kind, eprosima::fastdds::dds::SYNCHRONOUS_PUBLISH_MODE);
}

TEST_F(DdsTransportTest, AnAsynchronousWriterWithAFlowControllerDelivers) {
  const WireTopic topic{"rt/profiled", &message_type<std_msgs::msg::String>()};
  ReaderRecord heard;
  WriterRecord told;
  const auto reader = there_->create_reader(topic, QoS::reliable(), heard);
  const auto writer = here_->create_writer(topic, QoS::reliable(), told);
  ASSERT_TRUE(told.await_matched(1));
  ASSERT_TRUE(heard.await_matched(1));
  const auto message = make_text("at its own pace");
  EXPECT_GT(writer->write(&message, {}).sequence_number, 0);
  ASSERT_TRUE(heard.await_messages(1));
  EXPECT_EQ(heard.text(0), "at its own pace");
}

TEST(DdsTransportErrorTest, RefusesADomainWithoutPorts) {
  DdsOptions options = local_options();
  options.domain_id = 233;
  EXPECT_THROW((void)create_dds_transport(options), TransportError);
}

}  // namespace
}  // namespace pipescout
