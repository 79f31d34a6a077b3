// SPDX-License-Identifier: Apache-2.0
#include "broker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "number_process.hpp"
#include "pipescout/testing/fake_transport.hpp"

namespace pipescout {
namespace {

using ::testing::ElementsAre;
using testing::FakeNetwork;

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
      QoS::sensor_data(10), {.message_lost = [&](EventCount count) { lost = count.total; }});
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
    std::vector<Gid> matched_participants() const override {
      return inner_->matched_participants();
    }
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
