// SPDX-License-Identifier: Apache-2.0
#include "broker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <atomic>
#include <condition_variable>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "pipescout/runtime/context.hpp"
#include "pipescout/testing/fake_transport.hpp"

namespace pipescout {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using testing::FakeNetwork;
using ::testing::HasSubstr;

constexpr Duration kLong = seconds(30);

/// A message that counts what is done to it.
struct Number {
  std::int64_t value = 0;

  Number() = default;
  explicit Number(std::int64_t number) : value(number) {}
  Number(const Number& other) : value(other.value) { ++copies; }
  Number& operator=(const Number& other) {
    value = other.value;
    ++copies;
    return *this;
  }

  static inline std::atomic<int> copies{0};
  static inline std::atomic<int> serialisations{0};
  static inline std::atomic<int> deserialisations{0};
};

const MessageType kNumber{
    .name = "test_msgs/msg/Number",
    .dds_name = "test_msgs::msg::dds_::Number_",
    .create = []() -> std::shared_ptr<void> { return std::make_shared<Number>(); },
    .serialized_size = [](const void*) { return sizeof(std::int64_t); },
    .serialize =
        [](const void* message, std::span<std::byte> buffer) {
          ++Number::serialisations;
          std::memcpy(buffer.data(), &static_cast<const Number*>(message)->value,
                      sizeof(std::int64_t));
          return sizeof(std::int64_t);
        },
    .deserialize =
        [](std::span<const std::byte> buffer, void* message) {
          ++Number::deserialisations;
          if (buffer.size() != sizeof(std::int64_t)) {
            return false;
          }
          std::memcpy(&static_cast<Number*>(message)->value, buffer.data(), sizeof(std::int64_t));
          return true;
        },
};

const MessageType kOther{
    .name = "test_msgs/msg/Other",
    .dds_name = "test_msgs::msg::dds_::Other_",
    .create = kNumber.create,
    .serialized_size = kNumber.serialized_size,
    .serialize = kNumber.serialize,
    .deserialize = kNumber.deserialize,
};

const WireTopic kTopic{"rt/number", &kNumber};

std::shared_ptr<const Number> number(std::int64_t value) {
  return std::make_shared<const Number>(value);
}

/// A process of its own: context, executor, and what its subscriptions received.
struct Process {
  explicit Process(std::unique_ptr<Transport> transport = nullptr)
      : context(Context::create(std::move(transport))) {}

  std::shared_ptr<UntypedPublisher> publisher(const QoS& qos, PublisherEvents events = {}) const {
    return context->create_publisher(
        {.topic = kTopic, .qos = qos, .events = std::move(events), .group = group});
  }
  std::shared_ptr<UntypedSubscription> subscription(const QoS& qos,
                                                    SubscriptionEvents events = {}) {
    return context->create_subscription(
        {.topic = kTopic,
         .qos = qos,
         .callback =
             [this](const std::shared_ptr<const void>& message, const MessageInfo& info) {
               received.push_back(static_cast<const Number*>(message.get())->value);
               last_message = message;
               last_info = info;
             },
         .events = std::move(events),
         .group = group});
  }
  std::vector<std::int64_t> spin() {
    received.clear();
    executor.spin_ready();
    return received;
  }

  Executor executor;
  std::shared_ptr<CallbackGroup> group = executor.create_callback_group();
  std::shared_ptr<Context> context;
  std::vector<std::int64_t> received;
  std::shared_ptr<const void> last_message;
  MessageInfo last_info;
};

class InProcess : public ::testing::Test {
 protected:
  Process process_;
};

TEST_F(InProcess, TheSubscriberGetsTheVeryObjectWithoutCopyOrSerialisation) {
  const auto publisher = process_.publisher(QoS::reliable());
  const auto first = process_.subscription(QoS::reliable());
  const auto second = process_.subscription(QoS::sensor_data());
  Number::copies = Number::serialisations = Number::deserialisations = 0;
  const auto message = number(7);
  const PublishedSample sample = publisher->publish(message, {});
  EXPECT_THAT(process_.spin(), ElementsAre(7, 7));
  EXPECT_EQ(process_.last_message.get(), message.get());
  EXPECT_EQ(Number::copies, 0);
  EXPECT_EQ(Number::serialisations, 0);
  EXPECT_EQ(Number::deserialisations, 0);
  EXPECT_EQ(sample.local_sequence_number, 1);
  EXPECT_EQ(sample.remote_sequence_number, 0);
  EXPECT_TRUE(process_.last_info.from_this_process);
  EXPECT_EQ(process_.last_info.identity, (SampleIdentity{publisher->gid(), 1}));
  EXPECT_EQ(publisher->statistics().published, 1U);
  EXPECT_EQ(publisher->statistics().sent_to_other_processes, 0U);
}

TEST_F(InProcess, AFullQueueDropsTheOldestAndCounts) {
  std::vector<EventCount> lost;
  const auto publisher = process_.publisher(QoS::reliable(1));
  const auto subscription = process_.subscription(
      QoS::reliable(3), {.message_lost = [&](EventCount count) { lost.push_back(count); }});
  for (int i = 0; i < 10; ++i) {
    publisher->publish(number(i), {});
  }
  EXPECT_THAT(process_.spin(), ElementsAre(7, 8, 9));
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_EQ(lost[0].total, 7U);
  EXPECT_EQ(lost[0].change, 7U);
  const auto statistics = subscription->statistics();
  EXPECT_EQ(statistics.received, 10U);
  EXPECT_EQ(statistics.delivered, 3U);
  EXPECT_EQ(statistics.dropped_queue_full, 7U);
}

TEST_F(InProcess, ALateJoinerGetsTheSmallerOfTheTwoDepths) {
  rc::check([&] {
    const auto offered = *rc::gen::inRange<std::size_t>(1, 6);
    const auto requested = *rc::gen::inRange<std::size_t>(1, 6);
    const auto published = *rc::gen::inRange<std::size_t>(0, 8);
    const auto publisher = process_.publisher(QoS::latched(offered));
    std::vector<std::int64_t> expected;
    for (std::size_t i = 0; i < published; ++i) {
      publisher->publish(number(static_cast<std::int64_t>(i)), {});
      expected.push_back(static_cast<std::int64_t>(i));
    }
    const auto kept = std::min({offered, requested, published});
    expected.erase(expected.begin(), expected.end() - static_cast<std::ptrdiff_t>(kept));
    const auto late = process_.subscription(QoS::latched(requested));
    RC_ASSERT(process_.spin() == expected);
    RC_ASSERT(late->statistics().dropped_queue_full == 0U);
  });
}

TEST_F(InProcess, AVolatileLateJoinerGetsNothingOld) {
  const auto publisher = process_.publisher(QoS::latched(5));
  publisher->publish(number(1), {});
  const auto late = process_.subscription(QoS::reliable());
  EXPECT_THAT(process_.spin(), ElementsAre());
  publisher->publish(number(2), {});
  EXPECT_THAT(process_.spin(), ElementsAre(2));
}

// DDS 1.4, table in section 2.2.3, written down independently of incompatibility().
std::optional<QosPolicy> expected_incompatibility(const QoS& offered, const QoS& requested) {
  const auto longer = [](const std::optional<Duration>& a, const std::optional<Duration>& b) {
    return a.value_or(Duration::max()) > b.value_or(Duration::max());
  };
  if (requested.reliability == Reliability::kReliable &&
      offered.reliability == Reliability::kBestEffort) {
    return QosPolicy::kReliability;
  }
  if (requested.durability == Durability::kTransientLocal &&
      offered.durability == Durability::kVolatile) {
    return QosPolicy::kDurability;
  }
  if (longer(offered.deadline, requested.deadline)) {
    return QosPolicy::kDeadline;
  }
  if ((requested.liveliness == Liveliness::kManualByTopic &&
       offered.liveliness == Liveliness::kAutomatic) ||
      longer(offered.liveliness_lease, requested.liveliness_lease)) {
    return QosPolicy::kLiveliness;
  }
  return std::nullopt;
}

TEST(Qos, IsIncompatibleExactlyWhereTheDdsTableSaysSo) {
  const std::vector<std::optional<Duration>> spans{std::nullopt, seconds(1), seconds(2)};
  std::vector<QoS> all;
  for (const auto reliability : {Reliability::kBestEffort, Reliability::kReliable}) {
    for (const auto durability : {Durability::kVolatile, Durability::kTransientLocal}) {
      for (const auto liveliness : {Liveliness::kAutomatic, Liveliness::kManualByTopic}) {
        for (const auto& deadline : spans) {
          for (const auto& lease : spans) {
            all.push_back({.reliability = reliability,
                           .durability = durability,
                           .deadline = deadline,
                           .liveliness = liveliness,
                           .liveliness_lease = lease});
          }
        }
      }
    }
  }
  for (const QoS& offered : all) {
    for (const QoS& requested : all) {
      ASSERT_EQ(incompatibility(offered, requested), expected_incompatibility(offered, requested))
          << to_string(offered) << " / " << to_string(requested);
    }
  }
}

rc::Gen<QoS> arbitrary_qos() {
  const auto duration = rc::gen::map(rc::gen::inRange(0, 4), [](int hour) {
    return hour == 0 ? std::nullopt : std::optional<Duration>(hours(hour));
  });
  return rc::gen::build<QoS>(
      rc::gen::set(&QoS::reliability,
                   rc::gen::element(Reliability::kBestEffort, Reliability::kReliable)),
      rc::gen::set(&QoS::durability,
                   rc::gen::element(Durability::kVolatile, Durability::kTransientLocal)),
      rc::gen::set(&QoS::deadline, duration),
      rc::gen::set(&QoS::liveliness,
                   rc::gen::element(Liveliness::kAutomatic, Liveliness::kManualByTopic)),
      rc::gen::set(&QoS::liveliness_lease, duration));
}

TEST_F(InProcess, MatchesExactlyWhatTheDdsTableAllows) {
  rc::check([&] {
    const QoS offered = *arbitrary_qos();
    const QoS requested = *arbitrary_qos();
    const bool publisher_first = *rc::gen::arbitrary<bool>();
    std::vector<IncompatibleQos> publisher_told;
    std::vector<IncompatibleQos> subscription_told;
    const auto make_publisher = [&] {
      return process_.publisher(
          offered, {.incompatible_qos = [&](const auto& told) { publisher_told.push_back(told); }});
    };
    std::shared_ptr<UntypedPublisher> publisher;
    if (publisher_first) {
      publisher = make_publisher();
    }
    const auto subscription = process_.subscription(
        requested,
        {.incompatible_qos = [&](const auto& told) { subscription_told.push_back(told); }});
    if (!publisher_first) {
      publisher = make_publisher();
    }
    publisher->publish(number(1), {});
    const auto received = process_.spin();
    const auto policy = expected_incompatibility(offered, requested);
    const std::size_t matches = policy ? 0 : 1;
    RC_ASSERT(received.size() == matches);
    RC_ASSERT(publisher->subscription_count() == matches);
    RC_ASSERT(subscription->publisher_count() == matches);
    RC_ASSERT(publisher->statistics().incompatible_qos == 1 - matches);
    RC_ASSERT(subscription->statistics().incompatible_qos == 1 - matches);
    RC_ASSERT(publisher_told.size() == 1 - matches);
    RC_ASSERT(subscription_told.size() == 1 - matches);
    if (policy) {
      RC_ASSERT(publisher_told[0].policy == *policy);
      RC_ASSERT(publisher_told[0].count.total == 1U);
      RC_ASSERT(subscription_told[0].policy == *policy);
    }
  });
}

TEST_F(InProcess, CountsMatchesUpAndDown) {
  std::vector<std::size_t> publisher_told;
  std::vector<std::size_t> subscription_told;
  auto publisher = process_.publisher(
      QoS::reliable(), {.matched = [&](std::size_t count) { publisher_told.push_back(count); }});
  auto subscription = process_.subscription(
      QoS::reliable(), {.matched = [&](std::size_t count) { subscription_told.push_back(count); }});
  process_.spin();
  auto second = process_.subscription(QoS::reliable());
  process_.spin();
  EXPECT_EQ(publisher->subscription_count(), 2U);
  EXPECT_EQ(publisher->local_subscription_count(), 2);
  EXPECT_EQ(publisher->remote_subscription_count(), 0);
  second.reset();
  process_.spin();
  publisher.reset();
  process_.spin();
  EXPECT_THAT(publisher_told, ElementsAre(1, 2, 1));
  EXPECT_THAT(subscription_told, ElementsAre(1, 0));
  EXPECT_EQ(subscription->local_publisher_count(), 0);
}

TEST_F(InProcess, AnotherTypeOnATopicIsRefusedWithBothNames) {
  const auto publisher = process_.publisher(QoS::reliable());
  const auto refused = [&](const auto& make) {
    try {
      make();
      ADD_FAILURE() << "no exception";
    } catch (const TopicTypeMismatch& error) {
      EXPECT_THAT(error.what(), HasSubstr("rt/number"));
      EXPECT_THAT(error.what(), HasSubstr("test_msgs/msg/Number"));
      EXPECT_THAT(error.what(), HasSubstr("test_msgs/msg/Other"));
    }
  };
  const WireTopic other{"rt/number", &kOther};
  refused([&] { return process_.context->create_publisher({.topic = other}); });
  refused([&] {
    return process_.context->create_subscription(
        {.topic = other, .callback = [](const auto&, const auto&) {}});
  });
}

TEST_F(InProcess, ATopicIsFreeForAnotherTypeOnceItsEndpointsAreGone) {
  process_.publisher(QoS::reliable()).reset();
  process_.subscription(QoS::reliable()).reset();
  EXPECT_NE(process_.context->create_publisher({.topic = {"rt/number", &kOther}}), nullptr);
}

TEST_F(InProcess, RefusesWhatMakesNoSense) {
  EXPECT_THROW(process_.publisher(QoS::reliable(0)), std::invalid_argument);
  EXPECT_THROW(process_.context->create_subscription({.topic = kTopic}), std::invalid_argument);
  EXPECT_THROW(process_.context->create_publisher(
                   {.topic = kTopic, .events = {.matched = [](std::size_t) {}}}),
               std::invalid_argument);
  EXPECT_THROW(process_.context->create_subscription({.topic = kTopic,
                                                      .callback = [](const auto&, const auto&) {},
                                                      .events = {.matched = [](std::size_t) {}}}),
               std::invalid_argument);
  const auto publisher = process_.publisher(QoS::reliable());
  EXPECT_THROW(publisher->publish(nullptr, {}), std::invalid_argument);
}

TEST_F(InProcess, MissedDeadlinesAreToldOnBothSides) {
  QoS qos = QoS::reliable();
  qos.deadline = milliseconds(2);
  EventCount offered;
  EventCount requested;
  const auto publisher =
      process_.publisher(qos, {.deadline_missed = [&](EventCount count) { offered = count; }});
  const auto subscription =
      process_.subscription(qos, {.deadline_missed = [&](EventCount count) { requested = count; }});
  publisher->publish(number(1), {});
  EXPECT_TRUE(process_.executor.spin_until(
      [&] { return offered.total >= 2 && requested.total >= 2; }, kLong));
  EXPECT_GE(publisher->statistics().deadlines_missed, 2U);
  EXPECT_GE(subscription->statistics().deadlines_missed, 2U);
}

TEST_F(InProcess, NoDeadlineIsMissedWhileDisabled) {
  QoS qos = QoS::reliable();
  qos.deadline = Duration(1);
  const auto publisher = process_.publisher(qos);
  const auto subscription = process_.subscription(qos);
  publisher->publish(number(1), {});
  publisher->set_enabled(false);
  subscription->set_enabled(false);
  publisher->publish(number(2), {});
  process_.spin();
  EXPECT_EQ(publisher->statistics().deadlines_missed, 0U);
  EXPECT_EQ(subscription->statistics().deadlines_missed, 0U);
}

TEST_F(InProcess, ManualLivelinessIsLostAndRegained) {
  QoS qos = QoS::reliable();
  qos.liveliness = Liveliness::kManualByTopic;
  qos.liveliness_lease = milliseconds(2);
  std::vector<std::pair<int, int>> told;
  std::uint64_t lost = 0;
  auto publisher =
      process_.publisher(qos, {.liveliness_lost = [&](EventCount count) { lost = count.total; }});
  const auto subscription =
      process_.subscription(qos, {.liveliness_changed = [&](LivelinessChange now) {
                              told.emplace_back(now.alive, now.not_alive);
                            }});
  const auto wait_for = [&](std::pair<int, int> state) {
    return process_.executor.spin_until([&] { return !told.empty() && told.back() == state; },
                                        kLong);
  };
  EXPECT_TRUE(wait_for({0, 1}));
  EXPECT_TRUE(process_.executor.spin_until([&] { return lost == 1; }, kLong));
  EXPECT_EQ(subscription->liveliness().not_alive, 1);
  // Alive again, unless the lease has run out once more meanwhile.
  publisher->assert_liveliness();
  EXPECT_TRUE(subscription->liveliness().alive == 1 ||
              publisher->statistics().liveliness_lost == 2U);
  EXPECT_TRUE(process_.executor.spin_until([&] { return lost == 2; }, kLong));
  publisher->publish(number(1), {});
  EXPECT_TRUE(subscription->liveliness().alive == 1 ||
              publisher->statistics().liveliness_lost == 3U);
  EXPECT_TRUE(process_.executor.spin_until([&] { return lost == 3; }, kLong));
  EXPECT_EQ(publisher->statistics().liveliness_lost, 3U);
  publisher.reset();
  EXPECT_TRUE(wait_for({0, 0}));
}

TEST_F(InProcess, ALapseOfManualLivelinessIsNoticedWhileThePublishersCallbackHangs) {
  QoS qos = QoS::reliable();
  qos.liveliness = Liveliness::kManualByTopic;
  qos.liveliness_lease = milliseconds(2);
  const auto publisher = process_.publisher(qos);
  Executor monitor;
  bool noticed = false;
  const auto subscription = process_.context->create_subscription(
      {.topic = kTopic,
       .qos = qos,
       .callback = [](const std::shared_ptr<const void>&, const MessageInfo&) {},
       .events = {.liveliness_changed =
                      [&](LivelinessChange now) { noticed = now.not_alive == 1; }},
       .group = monitor.create_callback_group()});
  process_.group->post([&] {
    publisher->assert_liveliness();
    // Hangs until it was noticed.
    EXPECT_TRUE(monitor.spin_until([&] { return noticed; }, kLong));
  });
  process_.executor.spin_ready();
}

TEST_F(InProcess, ManualLivelinessIsWatchedWithoutACallbackGroup) {
  QoS qos = QoS::reliable();
  qos.liveliness = Liveliness::kManualByTopic;
  qos.liveliness_lease = milliseconds(2);
  const auto publisher = process_.context->create_publisher({.topic = kTopic, .qos = qos});
  bool lapsed = false;
  const auto subscription = process_.subscription(
      qos, {.liveliness_changed = [&](LivelinessChange now) { lapsed = now.not_alive == 1; }});
  EXPECT_TRUE(process_.executor.spin_until([&] { return lapsed; }, kLong));
}

TEST_F(InProcess, AutomaticLivelinessLastsAsLongAsThePublisher) {
  QoS qos = QoS::reliable();
  qos.liveliness_lease = Duration(1);
  auto publisher = process_.publisher(qos);
  const auto subscription = process_.subscription(qos);
  process_.spin();
  EXPECT_EQ(subscription->liveliness().alive, 1);
  publisher.reset();
  EXPECT_EQ(subscription->liveliness().alive, 0);
  EXPECT_EQ(subscription->liveliness().not_alive, 0);
}

TEST_F(InProcess, ExpiredMessagesAreNotDelivered) {
  QoS qos = QoS::latched(5);
  qos.lifespan = Duration(1);
  const auto publisher = process_.publisher(qos);
  const auto subscription = process_.subscription(QoS::latched(5));
  publisher->publish(number(1), {});
  // The system clock has moved on once it shows another time.
  const SystemClock clock;
  const Time published = clock.now();
  while (clock.now() <= published + Duration(1)) {
    std::this_thread::yield();
  }
  EXPECT_THAT(process_.spin(), ElementsAre());
  EXPECT_EQ(subscription->statistics().expired, 1U);
  EXPECT_EQ(subscription->statistics().delivered, 0U);
  const auto late = process_.subscription(QoS::latched(5));
  EXPECT_THAT(process_.spin(), ElementsAre());
  EXPECT_EQ(late->statistics().received, 0U);
}

TEST_F(InProcess, ADisabledPublisherDropsAndCounts) {
  const auto publisher = process_.publisher(QoS::latched(5));
  const auto subscription = process_.subscription(QoS::latched(5));
  publisher->set_enabled(false);
  EXPECT_EQ(publisher->publish(number(1), {}).local_sequence_number, 0);
  EXPECT_THAT(process_.spin(), ElementsAre());
  publisher->set_enabled(true);
  EXPECT_THAT(process_.spin(), ElementsAre());
  publisher->publish(number(2), {});
  EXPECT_THAT(process_.spin(), ElementsAre(2));
  EXPECT_EQ(publisher->statistics().suppressed, 1U);
  EXPECT_EQ(publisher->statistics().published, 1U);
}

TEST_F(InProcess, ADisabledSubscriptionKeepsTheLastMessagesForLater) {
  std::uint64_t lost = 0;
  const auto publisher = process_.publisher(QoS::reliable());
  const auto subscription = process_.subscription(
      QoS::reliable(2), {.message_lost = [&](EventCount count) { lost = count.total; }});
  publisher->publish(number(0), {});
  subscription->set_enabled(false);
  for (int i = 1; i < 4; ++i) {
    publisher->publish(number(i), {});
  }
  EXPECT_THAT(process_.spin(), ElementsAre());
  subscription->set_enabled(true);
  EXPECT_THAT(process_.spin(), ElementsAre(2, 3));
  EXPECT_EQ(subscription->statistics().dropped_inactive, 2U);
  EXPECT_EQ(subscription->statistics().dropped_queue_full, 0U);
  EXPECT_EQ(lost, 0U);
}

TEST_F(InProcess, ADisabledSubscriptionOfCommandsDropsThem) {
  const auto publisher = process_.publisher(QoS::reliable());
  std::uint64_t lost = 0;
  const auto subscription = process_.context->create_subscription(
      {.topic = kTopic,
       .callback =
           [this](const std::shared_ptr<const void>& message, const MessageInfo&) {
             process_.received.push_back(static_cast<const Number*>(message.get())->value);
           },
       .events = {.message_lost = [&](EventCount count) { lost = count.total; }},
       .group = process_.group,
       .while_inactive = WhileInactive::kDrop,
       .enabled = false});
  publisher->publish(number(0), {});
  subscription->set_enabled(true);
  publisher->publish(number(1), {});
  EXPECT_THAT(process_.spin(), ElementsAre(1));
  // Still in the queue when the component is deactivated.
  publisher->publish(number(2), {});
  subscription->set_enabled(false);
  publisher->publish(number(3), {});
  subscription->set_enabled(true);
  EXPECT_THAT(process_.spin(), ElementsAre());
  publisher->publish(number(4), {});
  EXPECT_THAT(process_.spin(), ElementsAre(4));
  EXPECT_EQ(subscription->statistics().dropped_inactive, 3U);
  EXPECT_EQ(subscription->statistics().received, 5U);
  EXPECT_EQ(lost, 0U);
}

TEST_F(InProcess, WithoutAGroupTheCallbackRunsAtOnce) {
  std::vector<std::int64_t> received;
  const auto subscription = process_.context->create_subscription(
      {.topic = kTopic,
       .callback = [&](const std::shared_ptr<const void>& message, const MessageInfo&) {
         received.push_back(static_cast<const Number*>(message.get())->value);
       }});
  const auto publisher = process_.publisher(QoS::reliable());
  publisher->publish(number(1), {});
  subscription->set_enabled(false);
  publisher->publish(number(2), {});
  subscription->set_enabled(true);
  publisher->publish(number(3), {});
  EXPECT_THAT(received, ElementsAre(1, 3));
  EXPECT_EQ(subscription->statistics().dropped_inactive, 1U);
  EXPECT_EQ(subscription->statistics().delivered, 2U);
}

TEST_F(InProcess, ABusyTopicDoesNotStarveAQuietOne) {
  const auto publisher = process_.publisher(QoS::reliable());
  const auto busy = process_.subscription(QoS::reliable(100));
  std::size_t received_before_quiet = 0;
  const WireTopic quiet_topic{"rt/quiet", &kNumber};
  const auto quiet = process_.context->create_subscription(
      {.topic = quiet_topic,
       .callback = [&](const auto&,
                       const auto&) { received_before_quiet = process_.received.size(); },
       .group = process_.group});
  const auto quiet_publisher = process_.context->create_publisher({.topic = quiet_topic});
  for (int i = 0; i < 100; ++i) {
    publisher->publish(number(i), {});
  }
  quiet_publisher->publish(number(0), {});
  process_.spin();
  EXPECT_EQ(received_before_quiet, 1U);
}

TEST_F(InProcess, ASubscriptionMayEndInItsOwnCallback) {
  const auto publisher = process_.publisher(QoS::reliable());
  int calls = 0;
  std::shared_ptr<UntypedSubscription> subscription =
      process_.context->create_subscription({.topic = kTopic,
                                             .callback =
                                                 [&](const auto&, const auto&) {
                                                   ++calls;
                                                   subscription.reset();
                                                 },
                                             .group = process_.group});
  publisher->publish(number(1), {});
  publisher->publish(number(2), {});
  process_.spin();
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(publisher->subscription_count(), 0U);
}

TEST_F(InProcess, NoCallbackBeginsAfterTheEnd) {
  const auto publisher = process_.publisher(QoS::reliable());
  auto subscription = process_.context->create_subscription(
      {.topic = kTopic,
       .qos = QoS::reliable(1),
       .callback = [](const auto&, const auto&) { FAIL(); },
       .events = {.liveliness_changed = [](LivelinessChange) { FAIL(); },
                  .message_lost = [](EventCount) { FAIL(); },
                  .matched = [](std::size_t) { FAIL(); }},
       .group = process_.group});
  auto other = process_.publisher(QoS::reliable(), {.matched = [](std::size_t) { FAIL(); }});
  publisher->publish(number(1), {});
  publisher->publish(number(2), {});
  subscription.reset();
  other.reset();
  EXPECT_THAT(process_.spin(), ElementsAre());
}

TEST_F(InProcess, EndpointsOutliveTheirContext) {
  const auto publisher = process_.publisher(QoS::reliable());
  auto subscription = process_.subscription(QoS::reliable());
  process_.context.reset();
  publisher->publish(number(1), {});
  EXPECT_THAT(process_.spin(), ElementsAre(1));
  subscription.reset();
  EXPECT_EQ(publisher->subscription_count(), 0U);
}

TEST_F(InProcess, HasOneSimulatedClockForEachTopic) {
  const auto clock = process_.context->simulated_clock();
  EXPECT_EQ(clock, process_.context->simulated_clock("/clock"));
  EXPECT_NE(clock, process_.context->simulated_clock("/other/clock"));
  EXPECT_EQ(clock->now(), Time{});
}

TEST(InProcessThreads, PublishingMatchingAndEndingSideBySide) {
  Process process;
  constexpr int kMessages = 300;
  std::atomic<int> received{0};
  std::thread spinner([&] { process.executor.spin(); });
  std::thread publishing([&] {
    const auto publisher = process.publisher(QoS::latched(3));
    for (int i = 0; i < kMessages; ++i) {
      publisher->publish(number(i), {});
    }
  });
  std::thread joining([&] {
    for (int i = 0; i < 100; ++i) {
      const auto subscription = process.context->create_subscription(
          {.topic = kTopic,
           .qos = QoS::latched(2),
           .callback = [&](const auto&, const auto&) { ++received; },
           .events = {.matched = [](std::size_t) {}},
           .group = process.group});
      subscription->set_enabled(false);
      subscription->set_enabled(true);
    }
  });
  publishing.join();
  joining.join();
  process.executor.stop();
  spinner.join();
}

/// Two processes on a wire that really serialises.
class AcrossProcesses : public ::testing::Test {
 protected:
  void settle() {
    while (network_.deliver() + here_.executor.spin_ready() + there_.executor.spin_ready() > 0) {
    }
  }

  FakeNetwork network_;
  Process here_{network_.create_transport("here")};
  Process there_{network_.create_transport("there")};
};

TEST_F(AcrossProcesses, ARemoteReaderGetsAnEqualMessageOfItsOwn) {
  const auto publisher = here_.publisher(QoS::reliable());
  const auto subscription = there_.subscription(QoS::reliable());
  settle();
  EXPECT_EQ(publisher->remote_subscription_count(), 1);
  EXPECT_EQ(subscription->remote_publisher_count(), 1);
  EXPECT_TRUE(publisher->is_matched_remotely(subscription->gid()));
  EXPECT_EQ(subscription->liveliness().alive, 1);
  const auto message = number(5);
  const SampleIdentity related{.writer = subscription->gid(), .sequence_number = 42};
  const PublishedSample sample = publisher->publish(message, related);
  settle();
  EXPECT_THAT(there_.received, ElementsAre(5));
  EXPECT_NE(there_.last_message.get(), message.get());
  EXPECT_FALSE(there_.last_info.from_this_process);
  EXPECT_EQ(there_.last_info.related, related);
  EXPECT_EQ(there_.last_info.identity,
            (SampleIdentity{publisher->gid(), sample.remote_sequence_number}));
}

TEST_F(AcrossProcesses, AMessageIsSerialisedOnceOrNotAtAll) {
  Number::copies = Number::serialisations = 0;
  const auto publisher = here_.publisher(QoS::reliable());
  const auto local = here_.subscription(QoS::reliable());
  settle();
  publisher->publish(number(1), {});
  EXPECT_EQ(Number::serialisations, 0);
  const auto remote = there_.subscription(QoS::reliable());
  const auto second = there_.subscription(QoS::reliable());
  settle();
  here_.received.clear();
  publisher->publish(number(2), {});
  EXPECT_EQ(Number::serialisations, 1);
  settle();
  EXPECT_EQ(Number::copies, 0);
  EXPECT_THAT(here_.received, ElementsAre(2));
  EXPECT_THAT(there_.received, ElementsAre(2, 2));
  EXPECT_EQ(publisher->statistics().published, 2U);
  EXPECT_EQ(publisher->statistics().sent_to_other_processes, 1U);
}

TEST_F(AcrossProcesses, ARemoteLateJoinerGetsWhatIsRetained) {
  Number::serialisations = 0;
  const auto publisher = here_.publisher(QoS::latched(2));
  for (int i = 1; i <= 3; ++i) {
    publisher->publish(number(i), {});
  }
  // The transport keeps them, so they are serialised without a reader, and only then.
  EXPECT_EQ(Number::serialisations, 3);
  const auto late = there_.subscription(QoS::latched(2));
  const auto later = there_.subscription(QoS::latched(1));
  const auto not_asking = there_.subscription(QoS::reliable());
  network_.deliver();
  settle();
  EXPECT_THAT(there_.received, ::testing::UnorderedElementsAre(2, 3, 3));
  EXPECT_EQ(not_asking->statistics().received, 0U);
  EXPECT_EQ(Number::serialisations, 3);
}

TEST_F(AcrossProcesses, CountsMatchesUpAndDownAlsoAfterACrash) {
  std::vector<std::size_t> publisher_told;
  std::vector<std::size_t> subscription_told;
  const auto publisher = here_.publisher(
      QoS::reliable(), {.matched = [&](std::size_t count) { publisher_told.push_back(count); }});
  auto subscription = there_.subscription(
      QoS::reliable(), {.matched = [&](std::size_t count) { subscription_told.push_back(count); }});
  settle();
  subscription.reset();
  settle();
  subscription = there_.subscription(QoS::reliable());
  settle();
  network_.crash(there_.context->transport()->participant());
  settle();
  EXPECT_THAT(publisher_told, ElementsAre(1, 0, 1, 0));
  EXPECT_THAT(subscription_told, ElementsAre(1));
  EXPECT_EQ(publisher->remote_subscription_count(), 0);
}

TEST_F(AcrossProcesses, IncompatibleQosIsToldOnBothSides) {
  std::optional<QosPolicy> publisher_told;
  std::optional<QosPolicy> subscription_told;
  const auto publisher = here_.publisher(
      QoS::sensor_data(),
      {.incompatible_qos = [&](const IncompatibleQos& told) { publisher_told = told.policy; }});
  const auto subscription = there_.subscription(
      QoS::reliable(),
      {.incompatible_qos = [&](const IncompatibleQos& told) { subscription_told = told.policy; }});
  settle();
  EXPECT_EQ(publisher_told, QosPolicy::kReliability);
  EXPECT_EQ(subscription_told, QosPolicy::kReliability);
  EXPECT_EQ(publisher->statistics().incompatible_qos, 1U);
  EXPECT_EQ(subscription->statistics().incompatible_qos, 1U);
}

TEST_F(AcrossProcesses, SubscriptionsOfOneTopicAndQosShareAReader) {
  Number::deserialisations = 0;
  const auto publisher = here_.publisher(QoS::reliable());
  std::vector<std::shared_ptr<UntypedSubscription>> subscriptions;
  std::vector<std::shared_ptr<const void>> received;
  for (int i = 0; i < 10; ++i) {
    subscriptions.push_back(there_.context->create_subscription(
        {.topic = kTopic,
         .qos = QoS::reliable(),
         .callback = [&](const std::shared_ptr<const void>& message,
                         const MessageInfo&) { received.push_back(message); },
         .group = there_.group}));
    settle();
    EXPECT_EQ(publisher->remote_subscription_count(), 1);
    EXPECT_EQ(subscriptions.back()->remote_publisher_count(), 1);
    EXPECT_EQ(subscriptions.back()->liveliness().alive, 1);
    EXPECT_EQ(subscriptions.back()->gid(), subscriptions.front()->gid());
  }
  publisher->publish(number(7), {});
  settle();
  ASSERT_EQ(received.size(), 10U);
  EXPECT_EQ(Number::deserialisations, 1);
  EXPECT_THAT(received, ::testing::Each(received.front()));
  for (const auto& subscription : subscriptions) {
    EXPECT_EQ(subscription->statistics().received, 1U);
  }

  // The reader goes with the last of them.
  received.clear();
  subscriptions.resize(1);
  publisher->publish(number(8), {});
  settle();
  EXPECT_EQ(received.size(), 1U);
  subscriptions.clear();
  settle();
  EXPECT_EQ(publisher->remote_subscription_count(), 0);
}

TEST_F(AcrossProcesses, AnotherQosOrAWishForItGetsAReaderOfItsOwn) {
  const auto publisher = here_.publisher(QoS::reliable());
  const auto first = there_.subscription(QoS::reliable(1));
  const auto deeper = there_.subscription(QoS::reliable(2));
  const auto own = there_.context->create_subscription({.topic = kTopic,
                                                        .qos = QoS::reliable(1),
                                                        .callback = [](const auto&, const auto&) {},
                                                        .group = there_.group,
                                                        .own_reader = true});
  const auto shared = there_.subscription(QoS::reliable(1));
  settle();
  EXPECT_EQ(publisher->remote_subscription_count(), 3);
  EXPECT_NE(own->gid(), first->gid());
  EXPECT_NE(deeper->gid(), first->gid());
  EXPECT_EQ(shared->gid(), first->gid());
}

TEST_F(AcrossProcesses, ALateSubscriptionOfAProcessGetsWhatTheWriterKeeps) {
  const auto publisher = here_.publisher(QoS::latched(2));
  for (int i = 1; i <= 3; ++i) {
    publisher->publish(number(i), {});
  }
  const auto first = there_.subscription(QoS::latched(5));
  const auto together = there_.subscription(QoS::latched(5));
  settle();
  EXPECT_EQ(publisher->remote_subscription_count(), 1);
  EXPECT_THAT(there_.received, ::testing::UnorderedElementsAre(2, 2, 3, 3));
  there_.received.clear();
  const auto late = there_.subscription(QoS::latched(5));
  settle();
  EXPECT_THAT(there_.received, ElementsAre(2, 3));
  there_.received.clear();
  publisher->publish(number(4), {});
  settle();
  EXPECT_THAT(there_.received, ElementsAre(4, 4, 4));
}

TEST_F(AcrossProcesses, ALateSubscriptionIsToldOfIncompatibleWriters) {
  const auto publisher = here_.publisher(QoS::sensor_data());
  const auto first = there_.subscription(QoS::reliable());
  settle();
  std::vector<QosPolicy> told;
  const auto late = there_.subscription(
      QoS::reliable(),
      {.incompatible_qos = [&](const IncompatibleQos& event) { told.push_back(event.policy); }});
  settle();
  EXPECT_THAT(told, ElementsAre(QosPolicy::kReliability));
  EXPECT_EQ(late->statistics().incompatible_qos, 1U);
  EXPECT_EQ(first->statistics().incompatible_qos, 1U);
}

TEST_F(AcrossProcesses, AThrowingCallbackTakesNothingFromTheOthers) {
  const auto publisher = here_.publisher(QoS::reliable());
  const auto throwing = there_.context->create_subscription(
      {.topic = kTopic, .qos = QoS::reliable(), .callback = [](const auto&, const auto&) {
         throw std::runtime_error("on purpose");
       }});
  const auto subscription = there_.subscription(QoS::reliable());
  settle();
  publisher->publish(number(1), {});
  EXPECT_THROW(network_.deliver(), std::runtime_error);
  settle();
  EXPECT_THAT(there_.received, ElementsAre(1));
}

TEST_F(AcrossProcesses, MalformedAndLostSamplesAreCounted) {
  std::uint64_t lost = 0;
  const auto publisher = here_.publisher(QoS::reliable());
  const auto subscription = there_.subscription(
      QoS::reliable(), {.message_lost = [&](EventCount count) { lost = count.total; }});
  settle();
  int samples = 0;
  network_.set_tamper([&](const std::string& topic, std::vector<std::byte>& bytes) {
    EXPECT_EQ(topic, "rt/number");
    ++samples;
    bytes.resize(samples == 1 ? 3 : bytes.size());
    return samples != 2;
  });
  for (int i = 1; i <= 3; ++i) {
    publisher->publish(number(i), {});
  }
  settle();
  EXPECT_THAT(there_.received, ElementsAre(3));
  EXPECT_EQ(subscription->statistics().malformed, 1U);
  EXPECT_EQ(subscription->statistics().lost_by_network, 1U);
  EXPECT_EQ(lost, 1U);
}

TEST_F(AcrossProcesses, ARemoteQueueIsBoundedToo) {
  const auto publisher = here_.publisher(QoS::reliable());
  const auto subscription = there_.subscription(QoS::reliable(2));
  settle();
  for (int i = 1; i <= 5; ++i) {
    publisher->publish(number(i), {});
  }
  network_.deliver();
  settle();
  EXPECT_THAT(there_.received, ElementsAre(4, 5));
  EXPECT_EQ(subscription->statistics().dropped_queue_full, 3U);
}

/// A transport whose writers take as long as the test wants.
class SlowTransport final : public Transport {
 public:
  explicit SlowTransport(std::unique_ptr<Transport> inner) : inner_(std::move(inner)) {}

  class Writer final : public TransportWriter {
   public:
    Writer(SlowTransport& transport, std::unique_ptr<TransportWriter> inner)
        : transport_(transport), inner_(std::move(inner)) {}
    SampleIdentity write(const void* message, const SampleIdentity& related) override {
      transport_.pass();
      return inner_->write(message, related);
    }
    int matched_remote_readers() const override { return inner_->matched_remote_readers(); }
    bool is_matched(const Gid& reader) const override { return inner_->is_matched(reader); }
    void assert_liveliness() override { inner_->assert_liveliness(); }
    Gid gid() const override { return inner_->gid(); }

   private:
    SlowTransport& transport_;
    const std::unique_ptr<TransportWriter> inner_;
  };

  std::unique_ptr<TransportWriter> create_writer(const WireTopic& topic, const QoS& qos,
                                                 TransportWriterListener& listener) override {
    return std::make_unique<Writer>(*this, inner_->create_writer(topic, qos, listener));
  }
  std::unique_ptr<TransportReader> create_reader(const WireTopic& topic, const QoS& qos,
                                                 TransportReaderListener& listener) override {
    return inner_->create_reader(topic, qos, listener);
  }
  Gid participant() const override { return inner_->participant(); }
  std::vector<DiscoveredParticipant> remote_participants() const override {
    return inner_->remote_participants();
  }
  std::vector<DiscoveredEndpoint> remote_endpoints() const override {
    return inner_->remote_endpoints();
  }
  void on_graph_changed(GraphChanged callback) override {
    inner_->on_graph_changed(std::move(callback));
  }
  std::unique_ptr<DelayedCall> create_delayed_call(std::function<void()> call) override {
    return inner_->create_delayed_call(std::move(call));
  }
  std::vector<std::string> warnings() const override { return inner_->warnings(); }

  /// From now on writers wait for `open`.
  void shut() {
    const std::lock_guard lock(mutex_);
    open_ = false;
  }
  void open() {
    {
      const std::lock_guard lock(mutex_);
      open_ = true;
    }
    changed_.notify_all();
  }
  void await_writers(int count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return waiting_ == count; });
  }

 private:
  void pass() {
    std::unique_lock lock(mutex_);
    ++waiting_;
    changed_.notify_all();
    changed_.wait(lock, [this] { return open_; });
    --waiting_;
  }

  const std::unique_ptr<Transport> inner_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = true;
  int waiting_ = 0;
};

class SlowSends : public AcrossProcesses {
 protected:
  void SetUp() override {
    subscription_ = there_.subscription(QoS::reliable());
    settle();
    while (network_.deliver() + slow_.executor.spin_ready() > 0) {
    }
    ASSERT_EQ(publisher_->remote_subscription_count(), 1);
    transport_->shut();
  }

  std::unique_ptr<SlowTransport> made_ =
      std::make_unique<SlowTransport>(network_.create_transport("slow"));
  SlowTransport* transport_ = made_.get();
  Process slow_{std::move(made_)};
  const std::shared_ptr<UntypedPublisher> publisher_ = slow_.publisher(QoS::reliable(3));
  std::shared_ptr<UntypedSubscription> subscription_;
};

TEST_F(SlowSends, KeepNobodyElseWaiting) {
  std::thread sender([&] { publisher_->publish(number(1), {}); });
  transport_->await_writers(1);
  // While the first message is on its way out, everything else of the publisher goes on.
  const auto local = slow_.subscription(QoS::reliable());
  EXPECT_EQ(publisher_->subscription_count(), 2U);
  EXPECT_EQ(publisher_->statistics().published, 1U);
  publisher_->assert_liveliness();
  const PublishedSample second = publisher_->publish(number(2), {});
  EXPECT_EQ(second.local_sequence_number, 2);
  EXPECT_EQ(second.remote_sequence_number, 0);
  EXPECT_THAT(slow_.spin(), ElementsAre(2));
  transport_->open();
  sender.join();
  settle();
  EXPECT_THAT(there_.received, ElementsAre(1, 2));
  EXPECT_EQ(publisher_->statistics().sent_to_other_processes, 2U);
  EXPECT_EQ(publisher_->publish(number(3), {}).remote_sequence_number, 3);
}

TEST_F(SlowSends, AreOvertakenOnlyBeyondTheDepth) {
  std::thread sender([&] { publisher_->publish(number(1), {}); });
  transport_->await_writers(1);
  for (int i = 2; i <= 6; ++i) {
    publisher_->publish(number(i), {});
  }
  transport_->open();
  sender.join();
  settle();
  EXPECT_THAT(there_.received, ElementsAre(1, 4, 5, 6));
  EXPECT_EQ(publisher_->statistics().send_failures, 2U);
}

}  // namespace
}  // namespace pipescout
