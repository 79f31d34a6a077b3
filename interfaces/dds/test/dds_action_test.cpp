// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <example_interfaces/action/fibonacci.hpp>
#include <optional>
#include <string>
#include <vector>

#include "dds_test_support.hpp"
#include "pipescout/runtime/node.hpp"
#include "pipescout/testing/action_race.hpp"

namespace pipescout {
namespace {

using example_interfaces::action::Fibonacci;
using ::testing::ElementsAre;

std::shared_ptr<Context> process() {
  return Context::create(create_dds_transport(dds_test::local_options()));
}

TEST(DdsActionTest, AGoalGoesThereAndFeedbackAndResultComeBack) {
  Executor executor;
  Node server_node({.context = process(),
                    .executor = &executor,
                    .name = {"/robot", "server"},
                    .standard_interfaces = false});
  Node client_node({.context = process(),
                    .executor = &executor,
                    .name = {"/robot", "client"},
                    .standard_interfaces = false});
  std::vector<ServerGoal<Fibonacci>> goals;
  auto server = server_node.create_action_server<Fibonacci>(
      "fibonacci",
      {.accepted = [&](ServerGoal<Fibonacci> goal) { goals.push_back(std::move(goal)); }});
  auto client = client_node.create_action_client<Fibonacci>("fibonacci");
  ASSERT_TRUE(executor.spin_until([&] { return client.is_ready(); }, dds_test::kGenerous));

  std::vector<std::string> told;
  const GoalCallbacks<Fibonacci> callbacks{
      .response =
          [&](const GoalResponse& response) {
            told.emplace_back(response.accepted ? "accepted" : "not accepted");
          },
      .feedback =
          [&](const std::shared_ptr<const Fibonacci::Feedback>& feedback) {
            told.push_back("feedback " + std::to_string(feedback->sequence.at(0)));
          },
      .result =
          [&](const GoalOutcome<Fibonacci>& outcome) {
            told.emplace_back(to_string(outcome.end));
          }};
  const auto wait_for = [&](std::size_t count) {
    return executor.spin_until([&] { return told.size() == count; }, dds_test::kGenerous);
  };
  Fibonacci::Goal goal;
  goal.order = 3;
  const GoalId id = client.send_goal(goal, callbacks);
  ASSERT_TRUE(wait_for(1));
  ASSERT_EQ(goals.size(), 1U);
  EXPECT_EQ(goals[0].goal().order, 3);
  Fibonacci::Feedback feedback;
  feedback.sequence = {7};
  EXPECT_TRUE(goals[0].publish_feedback(feedback));
  ASSERT_TRUE(wait_for(2));
  client.cancel(id);
  ASSERT_TRUE(executor.spin_until([&] { return goals[0].is_canceling(); }, dds_test::kGenerous));
  EXPECT_TRUE(goals[0].canceled());
  ASSERT_TRUE(wait_for(3));
  EXPECT_THAT(told, ElementsAre("accepted", "feedback 7", "canceled"));
}

TEST(DdsActionTest, AServerThatGoesIsNoticedAndTheNextOneTakesGoals) {
  Executor executor;
  Node client_node({.context = process(),
                    .executor = &executor,
                    .name = {"/robot", "client"},
                    .standard_interfaces = false});
  auto client = client_node.create_action_client<Fibonacci>("fibonacci");
  for (int round = 0; round < 2; ++round) {
    std::vector<ServerGoal<Fibonacci>> goals;
    std::optional<Node> server_node(std::in_place, NodeOptions{.context = process(),
                                                               .executor = &executor,
                                                               .name = {"/robot", "server"},
                                                               .standard_interfaces = false});
    auto server = server_node->create_action_server<Fibonacci>(
        "fibonacci",
        {.accepted = [&](ServerGoal<Fibonacci> goal) { goals.push_back(std::move(goal)); }});
    std::optional<GoalResponse> response;
    std::optional<GoalEnd> end;
    client.send_goal({},
                     {.response = [&](const GoalResponse& told) { response = told; },
                      .result = [&](const GoalOutcome<Fibonacci>& told) { end = told.end; }},
                     Duration::max());
    ASSERT_TRUE(executor.spin_until([&] { return !goals.empty(); }, dds_test::kGenerous));
    EXPECT_FALSE(end);
    server = {};
    const auto is_over = [&] { return end || (response && !response->accepted); };
    ASSERT_TRUE(executor.spin_until(is_over, dds_test::kGenerous));
    // How much of its last words is heard depends on how soon its writers are gone.
    if (end) {
      EXPECT_THAT(*end, ::testing::AnyOf(GoalEnd::kAborted, GoalEnd::kLost));
    } else {
      EXPECT_EQ(response->error, ServiceError::kServerGone);
    }
  }
}

TEST(DdsActionTest, CancellationsThatRaceWithTheEndLoseNoGoalAndContradictNone) {
  constexpr std::size_t kGoals = 1000;
  const auto report = testing::race_actions(process(), process(), {.goals = kGoals});
  EXPECT_EQ(report.lost, 0U);
  EXPECT_EQ(report.wrong, 0U) << ::testing::PrintToString(report.faults);
  EXPECT_EQ(report.succeeded + report.canceled, kGoals);
}

}  // namespace
}  // namespace pipescout
