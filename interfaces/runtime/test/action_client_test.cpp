// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/action_client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "fibonacci_action.hpp"
#include "pipescout/testing/fake_transport.hpp"

namespace pipescout {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::Contains;
using ::testing::ElementsAre;
using testing::FakeNetwork;
using ::testing::IsEmpty;

constexpr Duration kLong = seconds(30);

class ActionInProcess : public ::testing::Test {
 protected:
  void spin() { process_.executor.spin_ready(); }

  ActionProcess process_{"node"};
};

TEST_F(ActionInProcess, AClientIsToldOfResponseFeedbackAndResult) {
  FibonacciServer server(process_.node);
  FibonacciClient client(process_.node);
  EXPECT_TRUE(client.client.is_ready());
  const GoalId id = client.send(3);
  EXPECT_EQ(client.client.status(id), GoalStatus::kUnknown);
  spin();
  EXPECT_EQ(client.client.status(id), GoalStatus::kExecuting);
  EXPECT_EQ(server.goals.at(0).id(), id);
  EXPECT_EQ(server.goals.at(0).goal().order, 3);
  server.goals[0].publish_feedback(so_far({0}));
  server.goals[0].publish_feedback(so_far({0, 1}));
  spin();
  server.goals[0].succeed(numbers({0, 1, 1}));
  spin();
  EXPECT_THAT(client.told,
              ElementsAre("accepted", "feedback [0]", "feedback [0 1]", "succeeded [0 1 1]"));
  EXPECT_EQ(client.client.status(id), GoalStatus::kUnknown) << "it has ended";
  EXPECT_EQ(client.client.statistics().sent, 1U);
  EXPECT_EQ(client.client.statistics().ended, 1U);
}

TEST_F(ActionInProcess, AGoalThatEndsAtOnceLosesNothingAndKeepsTheOrder) {
  const auto server = process_.node.create_action_server<Fibonacci>(
      "fibonacci", {.accepted = [](const ServerGoal<Fibonacci>& goal) {
        goal.publish_feedback(so_far({1}));
        goal.publish_feedback(so_far({2}));
        goal.succeed(numbers({3}));
      }});
  FibonacciClient client(process_.node);
  client.send(1);
  spin();
  EXPECT_THAT(client.told,
              ElementsAre("accepted", "feedback [1]", "feedback [2]", "succeeded [3]"));
}

TEST_F(ActionInProcess, ARejectedGoalHasNoResult) {
  FibonacciServer server(process_.node);
  server.decision = GoalDecision::kReject;
  FibonacciClient client(process_.node);
  client.send(1);
  spin();
  EXPECT_THAT(client.told, ElementsAre("rejected"));
  EXPECT_EQ(client.client.statistics().ended, 0U);
}

TEST_F(ActionInProcess, WithoutServerTheResponseSaysSo) {
  FibonacciClient client(process_.node);
  EXPECT_FALSE(client.client.is_ready());
  client.send(1, milliseconds(1));
  client.client.cancel_all(client.note_cancel(), milliseconds(1));
  EXPECT_TRUE(process_.executor.spin_until([&] { return client.told.size() == 2; }, kLong));
  EXPECT_THAT(client.told, ElementsAre("no server", "cancel: no server"));
}

TEST_F(ActionInProcess, CancelsOneAllOrTheEarlierOnes) {
  FibonacciServer server(process_.node);
  FibonacciClient client(process_.node);
  FibonacciClient other(process_.node);
  const GoalId first = client.send(1);
  spin();
  const GoalId second = client.send(2);
  other.send(3);
  spin();
  client.told.clear();
  client.client.cancel(first, client.note_cancel());
  spin();
  EXPECT_EQ(client.client.status(first), GoalStatus::kCanceling);
  EXPECT_EQ(client.client.status(second), GoalStatus::kExecuting);
  server.goals[0].canceled(numbers({9}));
  client.client.cancel(first, client.note_cancel());
  client.client.cancel_not_after(server.goals[1].accepted_at(), client.note_cancel());
  spin();
  server.goals[1].succeed();
  client.client.cancel_all(client.note_cancel());
  client.client.cancel_all();
  spin();
  EXPECT_THAT(
      client.told,
      ElementsAre("cancel: canceling 1", "canceled [9]", "cancel: the goal has ended already 0",
                  "cancel: canceling 1", "succeeded []", "cancel: canceling 1"));
  EXPECT_EQ(server.goals[2].status(), GoalStatus::kCanceling);
}

TEST_F(ActionInProcess, AClientThatGoesEndsItsGoalsAndTheServerGoesOn) {
  FibonacciServer server(process_.node);
  std::optional<FibonacciClient> client(std::in_place, process_.node);
  client->send(1);
  spin();
  client->send(2);
  client->client.cancel_all(client->note_cancel());
  client->client = {};
  EXPECT_THAT(client->told,
              ::testing::UnorderedElementsAre("accepted", "cancelled", "left by its client",
                                              "cancel: cancelled"));
  spin();
  EXPECT_TRUE(server.goals.at(0).is_active());
  EXPECT_TRUE(server.goals[0].succeed());
  spin();
}

TEST_F(ActionInProcess, CallbacksMayBeMissing) {
  FibonacciServer server(process_.node);
  auto client = process_.node.create_action_client<Fibonacci>("fibonacci");
  client.send_goal(order(1));
  client.send_goal(order(2));
  spin();
  server.goals[0].publish_feedback(so_far({1}));
  server.goals[0].succeed();
  server.decision = GoalDecision::kReject;
  client.send_goal(order(3));
  spin();
  client = {};
}

TEST_F(ActionInProcess, ACallbackMayDestroyTheClient) {
  const auto server = process_.node.create_action_server<Fibonacci>(
      "fibonacci", {.accepted = [](const ServerGoal<Fibonacci>& goal) { goal.succeed(); }});
  for (const std::string when : {"response", "result"}) {
    auto client = process_.node.create_action_client<Fibonacci>("fibonacci");
    std::vector<std::string> told;
    client.send_goal(order(1), {.response =
                                    [&](const GoalResponse&) {
                                      told.emplace_back("response");
                                      if (when == "response") {
                                        client = {};
                                      }
                                    },
                                .result =
                                    [&](const GoalOutcome<Fibonacci>& outcome) {
                                      told.emplace_back(to_string(outcome.end));
                                      client = {};
                                    }});
    spin();
    EXPECT_THAT(told,
                ElementsAre("response", when == "response" ? "left by its client" : "succeeded"));
  }
}

TEST_F(ActionInProcess, AThrowingResponseLosesNoResult) {
  const auto server = process_.node.create_action_server<Fibonacci>(
      "fibonacci", {.accepted = [](const ServerGoal<Fibonacci>& goal) { goal.succeed(); }});
  FibonacciClient client(process_.node);
  auto callbacks = client.callbacks();
  callbacks.response = [](const GoalResponse&) { throw std::runtime_error("response"); };
  client.client.send_goal(order(1), callbacks);
  EXPECT_THROW(spin(), std::runtime_error);
  spin();
  EXPECT_THAT(client.told, ElementsAre("succeeded []"));
}

TEST_F(ActionInProcess, AnotherTypeUnderTheNameIsRefused) {
  const auto topic = process_.node.create_publisher<action_msgs::msg::GoalStatusArray>(
      "fibonacci/_action/feedback", QoS::reliable());
  EXPECT_THROW(FibonacciClient{process_.node}, TopicTypeMismatch);
  EXPECT_THROW(FibonacciServer{process_.node}, TopicTypeMismatch);
}

TEST_F(ActionInProcess, GoalsOfAClientAreBounded) {
  const FibonacciServer server(process_.node, {.max_goals = 2000});
  auto client = process_.node.create_action_client<Fibonacci>("fibonacci");
  for (std::size_t i = 0; i < UntypedActionClient::kMaxGoals; ++i) {
    client.send_goal(order(1));
  }
  EXPECT_THROW(client.send_goal(order(1)), std::runtime_error);
  spin();
  ASSERT_EQ(server.goals.size(), UntypedActionClient::kMaxGoals);
  server.goals[0].succeed();
  spin();
  client.send_goal(order(1));
  spin();
  EXPECT_EQ(server.goals.size(), UntypedActionClient::kMaxGoals + 1);
}

TEST_F(ActionInProcess, NamesAreRemapped) {
  Node remapped({.context = process_.context,
                 .executor = &process_.executor,
                 .name = {"/robot", "remapped"},
                 .remap_rules = {RemapRule::parse("fibonacci:=/other/numbers")},
                 .standard_interfaces = false});
  const FibonacciServer server(remapped);
  EXPECT_EQ(server.server.untyped()->name(), "/other/numbers");
  EXPECT_TRUE(process_.context->graph().topics().contains("/other/numbers/_action/status"));
}

/// Client and server in two processes.
class ActionAcrossProcesses : public ::testing::Test {
 protected:
  void settle() {
    while (network_.deliver() + here_.executor.spin_ready() +
               (there_ ? there_->executor.spin_ready() : 0) >
           0) {
    }
  }

  FakeNetwork network_;
  ActionProcess here_{"client", network_.create_transport("here")};
  std::optional<ActionProcess> there_{std::in_place, "server", network_.create_transport("there")};
  std::optional<FibonacciServer> server_{std::in_place, there_->node};
  FibonacciClient client_{here_.node};
};

TEST_F(ActionAcrossProcesses, WorksAsInOneProcess) {
  EXPECT_FALSE(client_.client.is_ready());
  settle();
  EXPECT_TRUE(client_.client.is_ready());
  client_.send(3);
  settle();
  server_->goals.at(0).publish_feedback(so_far({0, 1}));
  settle();
  server_->goals[0].succeed(numbers({0, 1, 1}));
  settle();
  EXPECT_THAT(client_.told, ElementsAre("accepted", "feedback [0 1]", "succeeded [0 1 1]"));
}

TEST_F(ActionAcrossProcesses, AGoalSentEarlyWaitsForTheServer) {
  client_.send(3);
  settle();
  EXPECT_THAT(client_.told, ElementsAre("accepted"));
}

TEST_F(ActionAcrossProcesses, FeedbackThatOvertakesTheResponseIsHeldBack) {
  settle();
  client_.send(3);
  // The request arrives, the server answers and publishes; all answers are on the wire together.
  network_.deliver();
  there_->executor.spin_ready();
  server_->goals.at(0).publish_feedback(so_far({1}));
  server_->goals[0].succeed(numbers({2}));
  settle();
  EXPECT_THAT(client_.told, ElementsAre("accepted", "feedback [1]", "succeeded [2]"));
}

TEST_F(ActionAcrossProcesses, AServerThatCrashesLosesItsGoals) {
  settle();
  client_.send(1);
  client_.send(2);
  settle();
  client_.told.clear();
  network_.crash(there_->context->transport()->participant());
  settle();
  EXPECT_THAT(client_.told, ElementsAre("lost with its server", "lost with its server"));
  EXPECT_EQ(client_.client.statistics().lost, 2U);
  EXPECT_FALSE(client_.client.is_ready());
}

TEST_F(ActionAcrossProcesses, AServerThatEndsInOrderAbortsItsGoals) {
  settle();
  client_.send(1);
  settle();
  server_.reset();
  settle();
  EXPECT_THAT(client_.told, ElementsAre("accepted", "aborted []"));
}

TEST_F(ActionAcrossProcesses, AServerThatStartsAnewDoesNotInheritGoals) {
  settle();
  client_.send(1);
  settle();
  ActionProcess again("server", network_.create_transport("again"));
  FibonacciServer restarted(again.node);
  const auto settle_all = [&] {
    while (again.executor.spin_ready() + network_.deliver() + here_.executor.spin_ready() > 0) {
    }
  };
  settle_all();
  network_.crash(there_->context->transport()->participant());
  settle_all();
  EXPECT_THAT(client_.told, ElementsAre("accepted", "lost with its server"));
  client_.told.clear();
  client_.send(2);
  settle_all();
  restarted.goals.at(0).succeed(numbers({4}));
  settle_all();
  EXPECT_THAT(client_.told, ElementsAre("accepted", "succeeded [4]"));
}

TEST_F(ActionAcrossProcesses, AServerThatGoesBeforeItsGoalIsLookedForLosesIt) {
  settle();
  client_.send(1);
  network_.deliver();
  there_->executor.spin_ready();
  network_.deliver();  // the response is here, and not looked at
  network_.crash(there_->context->transport()->participant());
  network_.deliver();
  here_.executor.spin_ready();
  settle();
  EXPECT_THAT(client_.told, ElementsAre("accepted", "lost with its server"));
}

TEST_F(ActionAcrossProcesses, ManyLostGoalsLeaveTheClientUsable) {
  // What waits for a result that never comes must not use up the calls of the client.
  for (int round = 0; round < 3; ++round) {
    settle();
    for (int i = 0; i < 90; ++i) {
      client_.send(1);
    }
    settle();
    network_.crash(there_->context->transport()->participant());
    settle();
    server_.reset();
    there_.emplace("server", network_.create_transport("again"));
    server_.emplace(there_->node);
  }
  settle();
  EXPECT_EQ(client_.client.statistics().lost, 270U);
  client_.told.clear();
  client_.send(1);
  settle();
  server_->goals.at(0).succeed();
  settle();
  EXPECT_THAT(client_.told, ElementsAre("accepted", "succeeded []"));
}

TEST_F(ActionAcrossProcesses, AClientThatCrashesLeavesItsGoalAndTheResultIsKept) {
  settle();
  const GoalId id = client_.send(1);
  settle();
  network_.crash(here_.context->transport()->participant());
  network_.deliver();
  there_->executor.spin_ready();
  EXPECT_TRUE(server_->goals.at(0).is_active());
  server_->goals[0].succeed(numbers({8}));
  ActionProcess other("other", network_.create_transport("other"));
  auto results =
      other.node.create_client<Fibonacci::Impl::GetResultService>("fibonacci/_action/get_result");
  Fibonacci::Impl::GetResultService::Request request;
  request.goal_id = to_message(id);
  std::optional<std::int32_t> told;
  results.call(std::move(request),
               [&](const Client<Fibonacci::Impl::GetResultService>::Result& result) {
                 ASSERT_TRUE(result);
                 told = result->result.sequence.at(0);
               });
  while (network_.deliver() + there_->executor.spin_ready() + other.executor.spin_ready() > 0) {
  }
  EXPECT_EQ(told, 8);
}

TEST_F(ActionAcrossProcesses, AnActionOfAnotherTypeIsNoServerOfThisOne) {
  server_.reset();
  using Other = action_msgs::msg::GoalStatusArray;
  const auto other =
      there_->node.create_publisher<Other>("other/_action/feedback", QoS::reliable());
  FibonacciClient client(here_.node, {}, "other");
  std::vector<std::string> logs;
  Logger logger = here_.node.logger();
  logger.set_sink(
      [&](LogSeverity, const std::string& text, const Logger::Location&) { logs.push_back(text); });
  settle();
  client.send(1, milliseconds(1));
  EXPECT_TRUE(here_.executor.spin_until([&] { return client.told.size() == 1; }, kLong));
  EXPECT_THAT(client.told, ElementsAre("no server"));
  EXPECT_THAT(logs, ElementsAre("action '/robot/other': no server of type "
                                "example_interfaces/action/Fibonacci, but somebody uses the name "
                                "with action_msgs/msg/GoalStatusArray"));
  logger.set_sink({});
}

TEST_F(ActionAcrossProcesses, MalformedRequestsAreDroppedAndTheServerGoesOn) {
  settle();
  network_.set_tamper([](const std::string& topic, std::vector<std::byte>& bytes) {
    if (topic == "rq/robot/fibonacci/_action/send_goalRequest") {
      bytes.resize(7);
    }
    return true;
  });
  client_.send(1, milliseconds(1));
  settle();
  EXPECT_TRUE(here_.executor.spin_until([&] { return client_.told.size() == 1; }, kLong));
  EXPECT_THAT(client_.told, ElementsAre("timeout"));
  network_.set_tamper({});
  client_.send(2);
  settle();
  EXPECT_THAT(client_.told, ElementsAre("timeout", "accepted"));
}

}  // namespace
}  // namespace pipescout
