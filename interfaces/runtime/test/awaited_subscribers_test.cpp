// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/awaited_subscribers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/runtime/context.hpp"
#include "pipescout/testing/fake_transport.hpp"

namespace pipescout {
namespace {

using ::testing::HasSubstr;
using Message = pipescout_msgs::msg::FusedOdometer;
using testing::FakeNetwork;
using Names = std::vector<std::string>;

/// A source of `left` and `right` in a process, listeners there and in another one.
class AwaitedSubscribersTest : public ::testing::Test {
 protected:
  struct Process {
    explicit Process(std::unique_ptr<Transport> transport)
        : context(Context::create(std::move(transport))) {}
    std::shared_ptr<Context> context;
    Executor executor;
  };

  struct Source {
    Source(Process& process, const Names& left, const Names& right)
        : node({.context = process.context,
                .executor = &process.executor,
                .name = {"/robot", "source"},
                .parameter_overrides = {{"wait_for_subscribers.left", ParameterValue(left)},
                                        {"wait_for_subscribers.right", ParameterValue(right)}}}),
          awaited(node, "it starts", {"left", "right"}),
          left_publisher(publisher("left")),
          right_publisher(publisher("right")) {}
    void watch() {
      awaited.watch({left_publisher.untyped(), right_publisher.untyped()}, [this] { ++arrivals; });
    }

    Node node;
    AwaitedSubscribers awaited;
    Publisher<Message> left_publisher;
    Publisher<Message> right_publisher;
    int arrivals = 0;

   private:
    Publisher<Message> publisher(const std::string& topic) {
      return node.create_publisher<Message>(topic, QoS::reliable(1),
                                            {.events = {.matched = awaited.on_matched()}});
    }
  };

  struct Listener {
    Listener(Process& process, const std::string& name, const Names& topics)
        : node({.context = process.context,
                .executor = &process.executor,
                .name = {"/robot", name}}) {
      for (const std::string& topic : topics) {
        subscriptions.push_back(
            node.create_subscription<Message>(topic, QoS::reliable(1), [](const Message&) {}));
      }
    }
    Node node;
    std::vector<Subscription<Message>> subscriptions;
  };

  void settle() {
    network_.deliver();
    here_.executor.spin_ready();
    there_.executor.spin_ready();
    network_.deliver();
    here_.executor.spin_ready();
  }

  FakeNetwork network_;
  Process here_{network_.create_transport("here")};
  Process there_{network_.create_transport("there")};
};

TEST_F(AwaitedSubscribersTest, NobodyIsAwaitedWithoutNames) {
  Source source(here_, {}, {});
  EXPECT_FALSE(source.awaited.all_there());
  source.watch();
  EXPECT_EQ(source.arrivals, 1);
  EXPECT_TRUE(source.awaited.all_there());
}

TEST_F(AwaitedSubscribersTest, ThoseThatAreThereAlreadyAreSeenAtOnce) {
  const Listener listener(here_, "listener", {"left", "right"});
  Source source(here_, {"listener"}, {"/robot/listener"});
  source.watch();
  EXPECT_EQ(source.arrivals, 1);
}

TEST_F(AwaitedSubscribersTest, OnlyTheNamedNodesCount) {
  Source source(here_, {"left_listener"}, {"right_listener"});
  source.watch();
  const Listener recorder(here_, "recorder", {"left", "right"});
  const Listener remote_recorder(there_, "remote_recorder", {"left", "right"});
  settle();
  EXPECT_EQ(source.arrivals, 0);
  const Listener left(here_, "left_listener", {"left"});
  settle();
  EXPECT_EQ(source.arrivals, 0);
  EXPECT_EQ(source.awaited.missing(), "/robot/right_listener to /robot/right");
  {
    const Listener right(there_, "right_listener", {"right"});
    settle();
    EXPECT_EQ(source.arrivals, 1);
    EXPECT_EQ(source.awaited.missing(), "");
  }
  settle();
  EXPECT_TRUE(source.awaited.all_there()) << "who listened may go";
  EXPECT_EQ(source.arrivals, 1);
}

TEST_F(AwaitedSubscribersTest, ARemoteNodeCountsOnceItIsMatchedWhateverComesFirst) {
  Source source(here_, {"listener"}, {});
  source.watch();
  const Listener listener(there_, "listener", {"left"});
  const Gid reader = listener.subscriptions[0].untyped()->gid();
  const auto is_matched = [&] {
    return source.left_publisher.untyped()->is_matched_remotely(reader);
  };
  do {
    here_.executor.spin_ready();
    there_.executor.spin_ready();
    EXPECT_TRUE(source.arrivals == 0 || is_matched());
  } while (network_.deliver_one());
  settle();
  EXPECT_EQ(source.arrivals, 1);
}

TEST_F(AwaitedSubscribersTest, NobodyIsAwaitedOnATopicThatIsNotPublished) {
  Source source(here_, {"listener"}, {"nobody"});
  const Listener listener(here_, "listener", {"left"});
  int arrivals = 0;
  source.awaited.watch({source.left_publisher.untyped(), nullptr}, [&] { ++arrivals; });
  EXPECT_EQ(arrivals, 1);
}

TEST_F(AwaitedSubscribersTest, WhoDoesNotComeIsLogged) {
  Source source(here_, {"late"}, {});
  std::string logged;
  Logger logger = source.node.logger();  // a copy shares its state
  logger.set_sink(
      [&](LogSeverity, const std::string& text, const Logger::Location&) { logged = text; });
  source.watch();
  here_.executor.spin_until([&] { return !logged.empty(); }, std::chrono::minutes(1));
  EXPECT_EQ(logged,
            "before it starts it waits for the subscriptions of /robot/late to /robot/left");
}

TEST_F(AwaitedSubscribersTest, StopsAndBeginsAgain) {
  Source source(here_, {"listener"}, {});
  source.watch();
  source.awaited.stop();
  const Listener listener(here_, "listener", {"left"});
  settle();
  EXPECT_EQ(source.arrivals, 0);
  EXPECT_FALSE(source.awaited.all_there());
  source.watch();
  EXPECT_EQ(source.arrivals, 1);
}

TEST_F(AwaitedSubscribersTest, AnInvalidNameIsRefusedWithItsParameter) {
  Source source(here_, {}, {"no name"});
  try {
    source.watch();
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("parameter 'wait_for_subscribers.right'"));
  }
  EXPECT_THROW(source.awaited.watch({source.left_publisher.untyped()}, [] {}),
               std::invalid_argument);
}

}  // namespace
}  // namespace pipescout
