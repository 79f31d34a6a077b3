// SPDX-License-Identifier: Apache-2.0
// Publishers and subscriptions of bytes, of types that need not be known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <memory>
#include <std_msgs/msg/string.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/runtime/names.hpp"
#include "pipescout/runtime/node.hpp"
#include "pipescout/runtime/serialized_message.hpp"
#include "pipescout/testing/fake_transport.hpp"

// After the headers whose enumerations have values of the same names.
#include "number_process.hpp"

namespace pipescout {
namespace {

using std_msgs::msg::String;
using ::testing::ElementsAre;
using ::testing::Pair;

std::vector<std::byte> bytes_of(std::span<const std::byte> bytes) {
  return {bytes.begin(), bytes.end()};
}

/// Listens as bytes in a process of numbers.
struct ByteListener {
  explicit ByteListener(Process& process, const QoS& qos = QoS::reliable())
      : subscription(process.context->create_subscription(
            {.topic = {kTopic.name, &serialized_type(kNumber.name)},
             .qos = qos,
             .callback =
                 [this](const std::shared_ptr<const void>& message, const MessageInfo& info) {
                   const auto serialized =
                       std::static_pointer_cast<const SerializedMessage>(message);
                   messages.push_back(serialized);
                   infos.push_back(info);
                   std::int64_t value = 0;
                   std::memcpy(&value, serialized->bytes().data(), sizeof value);
                   values.push_back(value);
                 },
             .group = process.group})) {}

  std::vector<std::shared_ptr<const SerializedMessage>> messages;
  std::vector<MessageInfo> infos;
  std::vector<std::int64_t> values;
  std::shared_ptr<UntypedSubscription> subscription;
};

SerializedMessage serialized_number(std::int64_t value) {
  return SerializedMessage(std::as_bytes(std::span(&value, 1)));
}

TEST(SerializedTypeTest, IsOneForEachNameAndNeedsNoSuchType) {
  const MessageType& type = serialized_type("nobody_msgs/msg/Unheard");
  EXPECT_EQ(&type, &serialized_type("nobody_msgs/msg/Unheard"));
  EXPECT_EQ(type.name, "nobody_msgs/msg/Unheard");
  EXPECT_EQ(type.dds_name, "nobody_msgs::msg::dds_::Unheard_");
  EXPECT_TRUE(is_serialized(type));
  EXPECT_FALSE(is_serialized(message_type<String>()));
  EXPECT_THROW(static_cast<void>(serialized_type("Unheard")), InvalidName);
}

TEST(SerializedTypeTest, KeepsTheBytesAndRefusesLessThanAnEncapsulationHeader) {
  const MessageType& type = serialized_type("nobody_msgs/msg/Unheard");
  const std::array bytes{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}, std::byte{7}};
  const auto message = type.create();
  ASSERT_TRUE(type.deserialize(bytes, message.get()));
  ASSERT_EQ(type.serialized_size(message.get()), bytes.size());
  std::array<std::byte, 5> written{};
  EXPECT_EQ(type.serialize(message.get(), written), bytes.size());
  EXPECT_EQ(written, bytes);
  EXPECT_EQ(type.serialize(message.get(), std::span(written).first(4)), 0U);
  EXPECT_FALSE(type.deserialize(std::span(bytes).first(3), message.get()));
  EXPECT_EQ(type.serialize(type.create().get(), written), 0U);
}

TEST(GenericSubscriptionTest, APublisherOfObjectsSerialisesOnceForAllOfThem) {
  Process process;
  Number::serialisations = Number::copies = 0;
  const auto publisher = process.publisher(QoS::reliable());
  const auto objects = process.subscription(QoS::reliable());
  ByteListener first(process);
  ByteListener second(process, QoS::sensor_data());
  publisher->publish(number(7), {});
  EXPECT_THAT(process.spin(), ElementsAre(7));
  EXPECT_THAT(first.values, ElementsAre(7));
  ASSERT_THAT(second.values, ElementsAre(7));
  EXPECT_EQ(first.messages[0], second.messages[0]);
  EXPECT_EQ(Number::serialisations, 1);
  EXPECT_EQ(Number::copies, 0);
  EXPECT_GT(first.infos[0].reception_time, Time{});
  EXPECT_EQ(first.infos[0].source_time, process.last_info.source_time);
}

TEST(GenericSubscriptionTest, WithoutOneNothingIsSerialised) {
  Process process;
  Number::serialisations = 0;
  const auto publisher = process.publisher(QoS::latched());
  publisher->publish(number(7), {});
  EXPECT_EQ(Number::serialisations, 0);
  // What is kept is serialised for the first late joiner, once.
  const ByteListener first(process, QoS::latched());
  const ByteListener second(process, QoS::latched());
  process.spin();
  EXPECT_THAT(first.values, ElementsAre(7));
  EXPECT_THAT(second.values, ElementsAre(7));
  EXPECT_EQ(Number::serialisations, 1);
}

TEST(GenericPublisherTest, SubscriptionsOfObjectsShareOneThatIsDecodedOnce) {
  Process process;
  Number::deserialisations = 0;
  const auto publisher = process.context->create_publisher(
      {.topic = {kTopic.name, &serialized_type(kNumber.name)}, .group = process.group});
  const auto first = process.subscription(QoS::reliable());
  const auto second = process.subscription(QoS::reliable());
  const ByteListener bytes(process);
  const auto message = std::make_shared<const SerializedMessage>(serialized_number(5));
  publisher->publish(message, {});
  EXPECT_THAT(process.spin(), ElementsAre(5, 5));
  EXPECT_EQ(Number::deserialisations, 1);
  EXPECT_EQ(bytes.messages.at(0), message);
}

TEST(GenericPublisherTest, BytesThatAreNoSuchMessageAreCountedAsMalformed) {
  Process process;
  const auto publisher = process.context->create_publisher(
      {.topic = {kTopic.name, &serialized_type(kNumber.name)}, .group = process.group});
  std::uint64_t told = 0;
  const auto subscription = process.subscription(
      QoS::reliable(), {.message_malformed = [&](EventCount count) { told = count.total; }});
  publisher->publish(std::make_shared<const SerializedMessage>(std::size_t{3}), {});
  EXPECT_TRUE(process.spin().empty());
  EXPECT_EQ(subscription->statistics().malformed, 1U);
  EXPECT_EQ(told, 1U);
}

TEST(GenericPublisherTest, AnotherTypeOnTheTopicIsRefused) {
  const Process process;
  const auto objects = process.publisher(QoS::reliable());
  EXPECT_THROW(static_cast<void>(process.context->create_publisher(
                   {.topic = {kTopic.name, &serialized_type("test_msgs/msg/Other")}})),
               TopicTypeMismatch);
}

/// Two nodes, each in a process of its own.
class GenericNodesTest : public ::testing::Test {
 protected:
  void settle() {
    while (network_.deliver() + here_executor_.spin_ready() + there_executor_.spin_ready() > 0) {
    }
  }

  testing::FakeNetwork network_;
  Executor here_executor_;
  Executor there_executor_;
  Node here_{{.context = Context::create(network_.create_transport("here")),
              .executor = &here_executor_,
              .name = {"/", "here"},
              .standard_interfaces = false}};
  Node there_{{.context = Context::create(network_.create_transport("there")),
               .executor = &there_executor_,
               .name = {"/", "there"},
               .standard_interfaces = false}};
};

TEST_F(GenericNodesTest, BytesArriveAsTheyWereSent) {
  std::vector<std::vector<std::byte>> received;
  const auto subscription = there_.create_generic_subscription(
      "words", "std_msgs/msg/String", QoS::reliable(),
      [&](const std::shared_ptr<const SerializedMessage>& message, const MessageInfo& info) {
        received.push_back(bytes_of(message->bytes()));
        EXPECT_GE(info.reception_time, info.source_time);
        EXPECT_FALSE(info.from_this_process);
      });
  std::vector<std::string> texts;
  const auto typed = there_.create_subscription<String>(
      "words", QoS::reliable(), [&](const String& text) { texts.push_back(text.data); });
  auto words = here_.create_publisher<String>("words", QoS::reliable());
  settle();
  String hello;
  hello.data = "hello";
  words.publish(hello);
  settle();
  ASSERT_EQ(received.size(), 1U);
  EXPECT_EQ(received[0], bytes_of(serialize(message_type<String>(), &hello)->bytes()));
  EXPECT_THAT(texts, ElementsAre("hello"));

  auto bytes = here_.create_generic_publisher("words", "std_msgs/msg/String", QoS::reliable());
  settle();
  bytes.publish(SerializedMessage(received[0]));
  settle();
  EXPECT_EQ(received.size(), 2U);
  EXPECT_THAT(texts, ElementsAre("hello", "hello"));
}

TEST_F(GenericNodesTest, ATypeThatNobodyKnowsIsCarriedAllTheSame) {
  std::vector<std::vector<std::byte>> received;
  const auto subscription = there_.create_generic_subscription(
      "secret", "nobody_msgs/msg/Unheard", QoS::reliable(),
      [&](const SerializedMessage& message) { received.push_back(bytes_of(message.bytes())); });
  auto publisher =
      here_.create_generic_publisher("secret", "nobody_msgs/msg/Unheard", QoS::reliable());
  settle();
  const std::vector bytes{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}, std::byte{9}};
  publisher.publish(SerializedMessage(bytes));
  settle();
  EXPECT_THAT(received, ElementsAre(bytes));
  EXPECT_EQ(there_.context().graph().topics().at("/secret"),
            std::set<std::string>{"nobody_msgs/msg/Unheard"});
}

TEST_F(GenericNodesTest, AtOnceMeansBeforePublishReturns) {
  std::vector<std::string> received;
  const auto subscription =
      here_.create_generic_subscription("words", "std_msgs/msg/String", QoS::reliable(),
                                        [&](const SerializedMessage& message) {
                                          const auto text = std::static_pointer_cast<const String>(
                                              deserialize(message_type<String>(), message.bytes()));
                                          received.push_back(text->data);
                                        },
                                        {.at_once = true});
  auto words = here_.create_publisher<String>("words", QoS::reliable());
  String hello;
  hello.data = "hello";
  words.publish(hello);
  EXPECT_THAT(received, ElementsAre("hello"));
  EXPECT_THROW(static_cast<void>(here_.create_generic_subscription(
                   "words", "std_msgs/msg/String", QoS::reliable(), [](const SerializedMessage&) {},
                   {.group = here_.default_group(), .at_once = true})),
               std::invalid_argument);
}

TEST(RequestForTest, AsksForWhatAllPublishersOffer) {
  const auto offer = [](Reliability reliability, Durability durability) {
    return QoS{.reliability = reliability, .durability = durability};
  };
  const auto chosen = [](const std::vector<QoS>& offered) {
    const QoS qos = request_for(offered, 7);
    EXPECT_EQ(qos.depth, 7U);
    for (const QoS& each : offered) {
      EXPECT_FALSE(incompatibility(each, qos));
    }
    return std::pair(qos.reliability, qos.durability);
  };
  using enum Reliability;
  using enum Durability;
  EXPECT_THAT(chosen({}), Pair(kReliable, kVolatile));
  EXPECT_THAT(chosen({offer(kReliable, kTransientLocal)}), Pair(kReliable, kTransientLocal));
  EXPECT_THAT(chosen({offer(kReliable, kTransientLocal), offer(kReliable, kVolatile)}),
              Pair(kReliable, kVolatile));
  EXPECT_THAT(chosen({offer(kBestEffort, kTransientLocal), offer(kReliable, kTransientLocal)}),
              Pair(kBestEffort, kTransientLocal));
}

}  // namespace
}  // namespace pipescout
