// SPDX-License-Identifier: Apache-2.0
// The commands' place on the network.
#include "cli/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <future>
#include <std_msgs/msg/header.hpp>
#include <std_srvs/srv/trigger.hpp>

#include "cli/topic_source.hpp"
#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/runtime/executor_thread.hpp"

namespace pipescout::host {
namespace {

using std_srvs::srv::Trigger;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// A session keeps the stop signals from the thread that makes it for good, as the program wants
/// it; the tests after this one and the programs that they start do not.
class SessionTest : public ::testing::Test {
 protected:
  SessionTest() { pthread_sigmask(SIG_SETMASK, nullptr, &mask_); }
  ~SessionTest() override { pthread_sigmask(SIG_SETMASK, &mask_, nullptr); }

 private:
  sigset_t mask_{};
};

TEST_F(SessionTest, ACallThatIsGivenUpLeavesNothingBehind) {
  // The client answers the call when it goes. That it then writes to what is still there, Clang's
  // AddressSanitizer sees (GCC's does not).
  Session session({.spin_time = 60.0, .timeout = 60.0});
  Executor executor;
  NodeOptions options;
  options.context = Context::create(create_dds_transport(DdsOptions::from_environment()));
  options.executor = &executor;
  options.name = {"/", "server"};
  Node server(std::move(options));
  const auto silent = server.create_service<Trigger>(
      "silent", [&session](const std::shared_ptr<const Trigger::Request>&,
                           const Responder<Trigger>&) { session.executor().stop(); });
  const auto loud = server.create_service<Trigger>(
      "loud", [](const Trigger::Request&, Trigger::Response& answer) { answer.message = "here"; });
  const ExecutorThread spinning(executor, {});
  EXPECT_THAT([&] { session.call<Trigger>("/silent"); },
              ThrowsMessage<CommandError>(HasSubstr("service /silent: ")));
  EXPECT_EQ(session.call<Trigger>("/loud")->message, "here");
}

TEST_F(SessionTest, ASourceIsHeardAsItsPublisherOffersThoughASubscriberIsDiscoveredFirst) {
  Session session({.spin_time = 60.0});
  Executor executor;
  NodeOptions options;
  options.context = Context::create(create_dds_transport(DdsOptions::from_environment()));
  options.executor = &executor;
  options.name = {"/", "robot"};
  Node robot(std::move(options));
  const auto subscription = robot.create_subscription<std_msgs::msg::Header>(
      "/found", QoS::latched(1), [](const auto&) {});
  ListenOptions listen;
  listen.topic = "/found";
  auto source = std::async(std::launch::async, [&] { return find_source(session, listen); });
  ASSERT_TRUE(session.wait_for([&] { return session.graph().topics().contains("/found"); }));
  session.settle();
  const auto publisher = robot.create_publisher<std_msgs::msg::Header>("/found", QoS::latched(1));
  const QoS qos = source.get().qos;
  EXPECT_EQ(qos.reliability, Reliability::kReliable);
  EXPECT_EQ(qos.durability, Durability::kTransientLocal);
}

}  // namespace
}  // namespace pipescout::host
