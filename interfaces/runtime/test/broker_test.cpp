// SPDX-License-Identifier: Apache-2.0
#include "broker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <atomic>
#include <memory>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "number_process.hpp"

namespace pipescout {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr Duration kLong = seconds(30);

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

}  // namespace
}  // namespace pipescout
