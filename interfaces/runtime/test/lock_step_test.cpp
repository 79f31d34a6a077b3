// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/lock_step.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <rosgraph_msgs/msg/clock.hpp>
#include <string>
#include <thread>
#include <vector>

#include "pipescout/runtime/context.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "pipescout/testing/fake_transport.hpp"

namespace pipescout {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Message = pipescout_msgs::msg::FusedOdometer;
using testing::FakeNetwork;

constexpr Duration kLong = seconds(30);
/// Between steps where nobody is waited for: lets `spin_ready` end.
constexpr Duration kPause = milliseconds(1);
constexpr std::uint64_t kEndless = 1'000'000'000;

NodeOptions node_options(const std::shared_ptr<Context>& context, Executor& executor,
                         const std::string& name, bool use_sim_time) {
  NodeOptions options{.context = context, .executor = &executor, .name = {.name = name}};
  options.parameter_overrides = {{"use_sim_time", ParameterValue(use_sim_time)}};
  return options;
}

/// Publishes the number of each step on `numbers`.
class Simulation {
 public:
  Simulation(const std::shared_ptr<Context>& context, Executor& executor, std::uint64_t steps,
             LockStepOptions options = {.time_out = kLong})
      : node(node_options(context, executor, "simulation", false)),
        steps_(steps),
        clock_(node.create_publisher(topics::kClock)),
        numbers_(node.create_publisher<Message>("numbers", QoS::reliable(1))),
        lock_step(
            node, *clock_.untyped(), options, [this] { return step(); },
            [this](const std::string& who, const std::string& why) {
              left_out.push_back(who);
              reasons.push_back(why);
            }) {}

  bool step() {
    if (on_step) {
      on_step();
    }
    ++done;
    rosgraph_msgs::msg::Clock clock;
    clock.clock = to_message(Time(seconds(done)));
    clock_.publish(std::move(clock));
    Message message;
    message.distance = static_cast<double>(done);
    numbers_.publish(std::move(message));
    return done < steps_;
  }

  [[nodiscard]] std::size_t listeners() const { return numbers_.subscription_count(); }

  Node node;
  std::uint64_t done = 0;
  std::vector<std::string> left_out;
  std::vector<std::string> reasons;
  std::function<void()> on_step;

 private:
  const std::uint64_t steps_;
  Publisher<rosgraph_msgs::msg::Clock> clock_;
  Publisher<Message> numbers_;

 public:
  LockStep lock_step;
};

/// Hands on what it gets, with queues of one message.
class Relay {
 public:
  Relay(const std::shared_ptr<Context>& context, Executor& executor, const std::string& name,
        const std::string& from, const std::string& to, bool use_sim_time = true,
        const QoS& requested = QoS::reliable(1))
      : node(node_options(context, executor, name, use_sim_time)),
        publisher_(node.create_publisher<Message>(to, QoS::reliable(1))),
        subscription(
            node.create_subscription<Message>(from, requested, [this](const Message& message) {
              if (on_message) {
                on_message();
              }
              received.push_back(message.distance);
              publisher_.publish(Message(message));
            })) {}

  Node node;
  std::vector<double> received;
  std::function<void()> on_message;

 private:
  Publisher<Message> publisher_;

 public:
  Subscription<Message> subscription;
};

std::vector<double> numbers_to(int last) {
  std::vector<double> numbers;
  for (int i = 1; i <= last; ++i) {
    numbers.push_back(i);
  }
  return numbers;
}

TEST(LockStep, RefusesTimesThatAreNone) {
  const auto context = Context::create_in_process();
  Executor executor;
  Node node(node_options(context, executor, "simulation", false));
  const auto clock = node.create_publisher(topics::kClock);
  const auto step = [] { return false; };
  EXPECT_THROW(LockStep(node, *clock.untyped(), {.period = -seconds(1)}, step, {}),
               std::invalid_argument);
  EXPECT_THROW(LockStep(node, *clock.untyped(), {.time_out = Duration::zero()}, step, {}),
               std::invalid_argument);
}

TEST(LockStep, AStepBeginsWhenAllIsDoneThatTheLastOneHasCaused) {
  const auto context = Context::create_in_process();
  Executor executor;
  Simulation simulation(context, executor, 100);
  Relay first(context, executor, "first", "numbers", "a");
  Relay second(context, executor, "second", "a", "b");
  Relay third(context, executor, "third", "b", "c");
  simulation.on_step = [&] { EXPECT_EQ(third.received.size(), simulation.done); };
  simulation.lock_step.resume();
  executor.spin_ready();
  EXPECT_EQ(third.received, numbers_to(100));
}

TEST(LockStep, WaitsForAllExecutorsOfTheProcess) {
  const auto context = Context::create_in_process();
  Executor executor;
  Executor other;
  Simulation simulation(context, executor, 1000);
  Relay first(context, other, "first", "numbers", "a");
  Relay second(context, executor, "second", "a", "b");
  std::thread thread([&] { other.spin(); });
  simulation.lock_step.resume();
  EXPECT_TRUE(executor.spin_until([&] { return second.received.size() == 1000; }, kLong));
  other.stop();
  thread.join();
  EXPECT_EQ(first.received, numbers_to(1000));
  EXPECT_EQ(second.received, numbers_to(1000));
  EXPECT_THAT(simulation.left_out, IsEmpty());
}

TEST(LockStep, PauseAndResume) {
  const auto context = Context::create_in_process();
  Executor executor;
  Simulation simulation(context, executor, 100);
  Relay relay(context, executor, "relay", "numbers", "a");
  relay.on_message = [&] {
    if (simulation.done == 40) {
      simulation.lock_step.pause();
    }
  };
  simulation.lock_step.resume();
  executor.spin_ready();
  EXPECT_EQ(simulation.done, 40U);
  simulation.lock_step.resume();
  simulation.lock_step.resume();
  executor.spin_ready();
  EXPECT_EQ(relay.received, numbers_to(100));
}

TEST(LockStep, StepsKeepThePeriodWhereTheConsumersDo) {
  const auto context = Context::create_in_process();
  Executor executor;
  Node node(node_options(context, executor, "simulation", false));
  const auto clock = node.create_publisher(topics::kClock);
  std::vector<SteadyTime> steps;
  LockStep lock_step(node, *clock.untyped(), {.period = milliseconds(5)},
                     [&] {
                       steps.push_back(steady_now());
                       return steps.size() < 5;
                     },
                     {});
  lock_step.resume();
  EXPECT_TRUE(executor.spin_until([&] { return steps.size() == 5; }, kLong));
  EXPECT_GE(steps.back() - steps.front(), milliseconds(4 * 5));
}

TEST(LockStep, ANodeThatHangsIsNamedAndLeftOut) {
  const auto context = Context::create_in_process();
  Executor executor;
  Executor hung;
  Simulation simulation(context, executor, 50, {.time_out = milliseconds(20)});
  Relay sound(context, executor, "sound", "numbers", "a");
  Relay hanging(context, hung, "hanging", "numbers", "b");
  std::promise<void> release;
  hanging.on_message = [&, future = release.get_future().share()] { future.wait(); };
  std::thread thread([&] { hung.spin(); });
  simulation.lock_step.resume();
  EXPECT_TRUE(executor.spin_until([&] { return sound.received.size() == 50; }, kLong));
  EXPECT_THAT(simulation.left_out, ElementsAre("node '/hanging'"));
  release.set_value();
  hung.stop();
  thread.join();
}

/// A simulation here, consumers there.
class LockStepAcrossProcesses : public ::testing::Test {
 protected:
  /// Turns the wheels of network and executors until `done`.
  bool run_until(const std::function<bool()>& done) {
    const SteadyTime end = steady_now() + kLong;
    while (!done()) {
      if (steady_now() > end) {
        return false;
      }
      std::size_t events = network_.deliver() + here_executor_.spin_ready();
      if (there_runs_) {
        events += there_executor_.spin_ready();
      }
      if (events == 0) {
        std::this_thread::yield();  // the threads of the contexts have their part
      }
    }
    return true;
  }

  FakeNetwork network_;
  Executor here_executor_;
  Executor there_executor_;
  bool there_runs_ = true;
  std::shared_ptr<Context> here_ = Context::create(network_.create_transport("here"));
  std::shared_ptr<Context> there_ = Context::create(network_.create_transport("there"));
};

TEST_F(LockStepAcrossProcesses, WaitsForTheNodesThatFollowItsClock) {
  Simulation simulation(here_, here_executor_, 200);
  Relay first(there_, there_executor_, "first", "numbers", "a");
  Relay second(here_, here_executor_, "second", "a", "b");
  Relay third(there_, there_executor_, "third", "b", "c");
  ASSERT_TRUE(run_until([&] { return simulation.listeners() == 1; }));
  ASSERT_TRUE(run_until([&] {
    return first.subscription.publisher_count() + second.subscription.publisher_count() +
               third.subscription.publisher_count() ==
           3;
  }));
  simulation.on_step = [&] { EXPECT_EQ(third.received.size(), simulation.done); };
  simulation.lock_step.resume();
  ASSERT_TRUE(run_until([&] { return third.received.size() == 200; }));
  EXPECT_EQ(third.received, numbers_to(200));
  EXPECT_THAT(simulation.left_out, IsEmpty());
}

TEST_F(LockStepAcrossProcesses, ReportsBelongToTheNodesThatFollowTheClock) {
  Simulation simulation(here_, here_executor_, 200);
  auto first = std::make_optional<Relay>(there_, there_executor_, "first", "numbers", "a");
  Relay second(there_, there_executor_, "second", "a", "b");
  const auto owners = [&](const Graph& graph) {
    std::vector<std::string> names;
    for (const GraphEndpoint& endpoint : graph.endpoints()) {
      if (endpoint.wire_topic == "rt/clock/_steps" && endpoint.is_publisher) {
        names.push_back(endpoint.node ? endpoint.node->name : "nobody");
      }
    }
    std::sort(names.begin(), names.end());
    return names;
  };
  const std::vector<std::string> both{"first", "second"};
  EXPECT_TRUE(run_until([&] { return owners(here_->graph()) == both; }));
  EXPECT_EQ(owners(there_->graph()), both);
  first.reset();
  EXPECT_TRUE(
      run_until([&] { return owners(here_->graph()) == std::vector<std::string>{"second"}; }));
}

TEST_F(LockStepAcrossProcesses, DoesNotWaitForWhoDoesNotFollowItsClock) {
  Simulation simulation(here_, here_executor_, 200);
  Relay recorder(there_, there_executor_, "recorder", "numbers", "a", false);
  ASSERT_TRUE(run_until([&] { return simulation.listeners() == 1; }));
  there_runs_ = false;
  simulation.lock_step.resume();
  EXPECT_TRUE(run_until([&] { return simulation.done == 200; }));
  EXPECT_THAT(simulation.left_out, IsEmpty());
}

TEST_F(LockStepAcrossProcesses, AProcessThatDoesNotAnswerIsNamedLeftOutAndWaitedForAgain) {
  Simulation simulation(here_, here_executor_, kEndless,
                        {.period = kPause, .time_out = milliseconds(20)});
  Relay relay(there_, there_executor_, "relay", "numbers", "a");
  ASSERT_TRUE(run_until([&] { return simulation.listeners() == 1; }));
  simulation.lock_step.resume();
  ASSERT_TRUE(run_until([&] { return relay.received.size() == 10; }));
  there_runs_ = false;
  ASSERT_TRUE(run_until([&] { return !simulation.left_out.empty(); }));
  EXPECT_THAT(simulation.left_out, ElementsAre("the process of node '/relay'"));
  EXPECT_THAT(simulation.reasons,
              ElementsAre(::testing::ContainsRegex(
                  "it has not reported the end of message [0-9]+ of 'rt/[a-z]+' "
                  "of node '/simulation', but of message [0-9]+")));
  const std::uint64_t then = simulation.done;
  ASSERT_TRUE(run_until([&] { return simulation.done > then + 10; }));
  there_runs_ = true;
  // Once it has caught up no step is missed any more.
  ASSERT_TRUE(run_until([&] {
    const auto& received = relay.received;
    return received.size() > 100 && received.back() == received[received.size() - 50] + 49;
  }));
}

// A simulation waits for each message, also for a subscription that would do without some.
TEST_F(LockStepAcrossProcesses, NoMessageIsLostWhereASubscriptionAsksForBestEffort) {
  Simulation simulation(here_, here_executor_, 200);
  Relay relay(there_, there_executor_, "relay", "numbers", "a", true, QoS::sensor_data(1));
  ASSERT_TRUE(run_until([&] { return simulation.listeners() == 2; }));
  std::uint64_t samples = 0;
  network_.set_tamper([&](const std::string& topic, std::vector<std::byte>&) {
    return topic == "rt/clock/_steps" || ++samples % 7 != 0;
  });
  simulation.lock_step.resume();
  ASSERT_TRUE(run_until([&] { return simulation.done == 200 || !simulation.left_out.empty(); }));
  ASSERT_TRUE(run_until([&] { return relay.received.size() == 200; }));
  EXPECT_THAT(simulation.left_out, IsEmpty());
  EXPECT_EQ(relay.received, numbers_to(200));
  EXPECT_EQ(relay.subscription.publisher_count(), 1U);
}

TEST_F(LockStepAcrossProcesses, AWriterThatOffersBestEffortOnlyIsHeardToo) {
  Node camera(node_options(here_, here_executor_, "camera", false));
  auto publisher = camera.create_publisher<Message>("images", QoS::sensor_data(5));
  Relay relay(there_, there_executor_, "relay", "images", "a", true, QoS::sensor_data(5));
  ASSERT_TRUE(run_until([&] { return relay.subscription.publisher_count() == 1; }));
  for (int i = 1; i <= 3; ++i) {
    Message message;
    message.distance = i;
    publisher.publish(std::move(message));
  }
  ASSERT_TRUE(run_until([&] { return relay.received.size() == 3; }));
  EXPECT_EQ(relay.received, numbers_to(3));
  EXPECT_EQ(publisher.untyped()->statistics().incompatible_qos, 0U);
}

TEST_F(LockStepAcrossProcesses, AMalformedMessageIsNotWaitedFor) {
  Simulation simulation(here_, here_executor_, 20);
  Relay relay(there_, there_executor_, "relay", "numbers", "a");
  ASSERT_TRUE(run_until([&] { return simulation.listeners() == 1; }));
  network_.set_tamper([&](const std::string& topic, std::vector<std::byte>& bytes) {
    if (topic == "rt/numbers" && simulation.done == 5) {
      bytes.resize(bytes.size() / 2);
    }
    return true;
  });
  simulation.lock_step.resume();
  ASSERT_TRUE(run_until([&] { return simulation.done == 20 || !simulation.left_out.empty(); }));
  EXPECT_THAT(simulation.left_out, IsEmpty());
  EXPECT_EQ(relay.subscription.statistics().malformed, 1U);
}

TEST_F(LockStepAcrossProcesses, AMessageToASubscriptionThatGoesIsNotWaitedFor) {
  Simulation simulation(here_, here_executor_, 20);
  std::optional<Relay> relay;
  relay.emplace(there_, there_executor_, "relay", "numbers", "a");
  const Node stays(node_options(there_, there_executor_, "stays", true));
  ASSERT_TRUE(run_until([&] { return simulation.listeners() == 1; }));
  simulation.lock_step.resume();
  while (simulation.done < 6) {
    here_executor_.spin_ready();
    if (simulation.done < 6) {
      network_.deliver();
      there_executor_.spin_ready();
    }
  }
  relay.reset();  // the message of the last step is on its way
  ASSERT_TRUE(run_until([&] { return simulation.done == 20 || !simulation.left_out.empty(); }));
  EXPECT_THAT(simulation.left_out, IsEmpty());
}

TEST_F(LockStepAcrossProcesses, AProcessThatDiesIsNotWaitedFor) {
  Simulation simulation(here_, here_executor_, kEndless, {.period = kPause, .time_out = kLong});
  Relay relay(there_, there_executor_, "relay", "numbers", "a");
  ASSERT_TRUE(run_until([&] { return simulation.listeners() == 1; }));
  simulation.lock_step.resume();
  ASSERT_TRUE(run_until([&] { return relay.received.size() == 10; }));
  there_runs_ = false;
  network_.crash(there_->transport()->participant());
  const std::uint64_t then = simulation.done;
  ASSERT_TRUE(run_until([&] { return simulation.done > then + 10; }));
  EXPECT_THAT(simulation.left_out, IsEmpty());
}

}  // namespace
}  // namespace pipescout
