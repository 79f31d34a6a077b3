// SPDX-License-Identifier: Apache-2.0
// The commands on actions, with a server in this process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <example_interfaces/action/fibonacci.hpp>
#include <mutex>
#include <string>
#include <vector>

#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/runtime/executor_thread.hpp"
#include "pipescout/runtime/goal_rejected.hpp"
#include "pipescout/runtime/node.hpp"
#include "program.hpp"

namespace pipescout::host {
namespace {

using example_interfaces::action::Fibonacci;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;

/// Order 0 is rejected; 1 to 9 are computed at once, with a feedback; more never ends by itself.
class ActionCommand : public ::testing::Test {
 protected:
  void accepted(const ServerGoal<Fibonacci>& goal) {
    if (goal.goal().order >= 10) {
      const std::lock_guard lock(mutex_);
      kept_ = goal;
      return;
    }
    Fibonacci::Feedback feedback;
    feedback.sequence = {0, 1};
    goal.publish_feedback(feedback);
    Fibonacci::Result result;
    result.sequence = {0, 1};
    for (std::int32_t i = 0; i < goal.goal().order; ++i) {
      result.sequence.push_back(*(result.sequence.end() - 1) + *(result.sequence.end() - 2));
    }
    goal.succeed(std::move(result));
  }

  Finished run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin() + 2, {"--spin-time", "30"});
    return run_program(arguments, folder_.path());
  }
  /// A participant whose announcement was lost is missing until the next one, seconds later.
  void expect_listed(const std::vector<std::string>& arguments,
                     const ::testing::Matcher<std::string>& matcher) {
    std::string text;
    eventually([&] {
      text = run(arguments).out;
      return matcher.Matches(text);
    });
    EXPECT_THAT(text, matcher);
  }
  Finished send(const std::string& goal) {
    return run({"action", "send_goal", "/robot/fibonacci", "example_interfaces/action/Fibonacci",
                goal, "-f"});
  }

  ::pipescout::testing::TemporaryFolder folder_;
  std::shared_ptr<Context> context_ =
      Context::create(create_dds_transport(DdsOptions::from_environment()));
  Executor executor_;
  std::mutex mutex_;
  ServerGoal<Fibonacci> kept_;
  Node node_{{.context = context_, .executor = &executor_, .name = {"/robot", "mathematician"}}};
  ActionServer<Fibonacci> server_ = node_.create_action_server<Fibonacci>(
      "fibonacci", {.decide =
                        [](const GoalId&, const std::shared_ptr<const Fibonacci::Goal>& goal) {
                          if (goal->order == 0) {
                            throw GoalRejected("a sequence of nothing");
                          }
                          return goal->order < 0 ? GoalDecision::kReject : GoalDecision::kAccept;
                        },
                    .accepted = [this](const ServerGoal<Fibonacci>& goal) { accepted(goal); },
                    .canceling = [](const ServerGoal<Fibonacci>& goal) { goal.canceled(); }});
  ExecutorThread thread_{executor_, {}};
};

TEST_F(ActionCommand, ListsActionsAndTheirNodes) {
  using ::testing::Eq;
  expect_listed({"action", "list"}, Eq("/robot/fibonacci\n"));
  expect_listed({"action", "list", "-t"},
                Eq("/robot/fibonacci [example_interfaces/action/Fibonacci]\n"));
  expect_listed({"action", "list", "-c"}, Eq("1\n"));
  expect_listed({"action", "info", "/robot/fibonacci", "-t"},
                Eq("Action: /robot/fibonacci\nAction clients: 0\nAction servers: 1\n"
                   "    /robot/mathematician [example_interfaces/action/Fibonacci]\n"));
  expect_listed({"action", "info", "/nothing"},
                Eq("Action: /nothing\nAction clients: 0\nAction servers: 0\n"));
  expect_listed({"node", "info", "/robot/mathematician"},
                HasSubstr("  Action Servers:\n"
                          "    /robot/fibonacci: example_interfaces/action/Fibonacci\n"));
}

TEST_F(ActionCommand, ThePartsOfAnActionAreHidden) {
  for (const std::string kind : {"service", "topic"}) {
    EXPECT_THAT(run({kind, "list"}).out, Not(HasSubstr("_action")));
    expect_listed({kind, "list", "-a"},
                  HasSubstr(kind == "topic" ? "/robot/fibonacci/_action/status\n"
                                            : "/robot/fibonacci/_action/send_goal\n"));
  }
}

TEST_F(ActionCommand, SendsAGoalAndPrintsWhatComesOfIt) {
  // Nobody gets a feedback that the server publishes before it has discovered the new client, whose
  // side of the match is all that the client can wait for: as with rclcpp.
  std::string text;
  eventually([&] {
    const auto finished = send("{order: 3}");
    EXPECT_EQ(finished.code(), 0) << finished.err;
    text = finished.out;
    return text.find("Feedback:") != std::string::npos;
  });
  EXPECT_THAT(text, MatchesRegex("Waiting for an action server to become available...\n"
                                 "Sending goal:\n     order: 3\n\n"
                                 "Goal accepted with ID: [0-9a-f]{32}\n\n"
                                 "Feedback:\n    sequence:\n- 0\n- 1\n\n"
                                 "Result:\n    sequence:\n- 0\n- 1\n- 1\n- 2\n- 3\n\n"
                                 "Goal finished with status: SUCCEEDED\n"));
}

TEST_F(ActionCommand, TellsOfARejectedGoalAndWhy) {
  const auto finished = send("{order: 0}");
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.out, HasSubstr("\nGoal was rejected.\n"));
  EXPECT_THAT(
      finished.err,
      MatchesRegex("The log of the server says: robot.mathematician: action "
                   "'/robot/fibonacci': goal [0-9a-f]{32} rejected: a sequence of nothing\n"));
  EXPECT_THAT(send("{order: -1}").err, HasSubstr(" rejected: the server gives no reason\n"));
}

TEST_F(ActionCommand, ASignalCancelsTheGoal) {
  Program program({"action", "send_goal", "/robot/fibonacci", "example_interfaces/action/Fibonacci",
                   "{order: 10}"},
                  folder_.path());
  ASSERT_TRUE(program.wait_for_out("Goal accepted with ID"));
  program.signal(SIGINT);
  const auto finished = program.finish();
  EXPECT_EQ(finished.code(), 128 + SIGINT);
  EXPECT_THAT(finished.out, HasSubstr("Canceling goal...\nGoal canceled.\n"));
  EXPECT_EQ(server_.statistics().canceled, 1U);
}

TEST_F(ActionCommand, SaysWhatIsWrong) {
  EXPECT_THAT(
      run({"action", "send_goal", "/robot/fibonacci", "example_interfaces/action/Nothing"}).err,
      HasSubstr("The passed action type is invalid: "));
  EXPECT_THAT(send("{ordr: 3}").err, HasSubstr("Failed to populate message fields: "));
  const auto other =
      run({"action", "send_goal", "/robot/fibonacci", "nav2_msgs/action/NavigateToPose"});
  EXPECT_EQ(other.code(), 1);
  EXPECT_EQ(
      other.err,
      "The action '/robot/fibonacci' is served as example_interfaces/action/Fibonacci, not as "
      "nav2_msgs/action/NavigateToPose\n");
  EXPECT_EQ(run({"action", "list", "--nothing"}).code(), 2);
}

}  // namespace
}  // namespace pipescout::host
