// SPDX-License-Identifier: Apache-2.0
#include "fibonacci_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "pipescout/testing/component_harness.hpp"

namespace {

using example_interfaces::action::Fibonacci;
using pipescout::GoalOutcome;
using ::testing::ElementsAre;

class FibonacciServerTest : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(harness_.bring_up(server_).success); }

  pipescout::GoalId send(std::int32_t order) {
    Fibonacci::Goal goal;
    goal.order = order;
    const auto id = client_.send_goal(
        goal,
        {.response =
             [this](const pipescout::GoalResponse& response) { accepted_ = response.accepted; },
         .feedback =
             [this](const std::shared_ptr<const Fibonacci::Feedback>& feedback) {
               so_far_ = feedback->sequence;
             },
         .result = [this](const GoalOutcome<Fibonacci>& outcome) { outcome_ = outcome; }});
    harness_.spin();
    return id;
  }

  pipescout::testing::ComponentHarness harness_{{.simulated_time = true}};
  tutorial::FibonacciServer& server_ =
      harness_.make<tutorial::FibonacciServer>({.parameters = {{"period", 1.0}}});
  pipescout::ActionClient<Fibonacci> client_ =
      harness_.peer().create_action_client<Fibonacci>("fibonacci");
  bool accepted_ = false;
  std::vector<std::int32_t> so_far_;
  std::optional<GoalOutcome<Fibonacci>> outcome_;
};

TEST_F(FibonacciServerTest, ComputesANumberEachPeriod) {
  send(2);
  EXPECT_TRUE(accepted_);
  harness_.advance(std::chrono::seconds(1));
  EXPECT_THAT(so_far_, ElementsAre(0, 1, 1));
  EXPECT_FALSE(outcome_);
  harness_.advance(std::chrono::seconds(1));
  ASSERT_TRUE(outcome_);
  EXPECT_TRUE(*outcome_) << to_string(outcome_->end);
  EXPECT_THAT(outcome_->result->sequence, ElementsAre(0, 1, 1, 2));
}

TEST_F(FibonacciServerTest, StopsWhenItIsAskedTo) {
  const auto id = send(9);
  harness_.advance(std::chrono::seconds(1));
  client_.cancel(id);
  harness_.spin();
  ASSERT_TRUE(outcome_);
  EXPECT_EQ(outcome_->end, pipescout::GoalEnd::kCanceled);
  EXPECT_THAT(outcome_->result->sequence, ElementsAre(0, 1, 1));
}

TEST_F(FibonacciServerTest, ANewGoalTakesThePlaceOfTheOld) {
  send(9);
  harness_.advance(std::chrono::seconds(1));
  send(1);
  ASSERT_TRUE(outcome_);
  EXPECT_EQ(outcome_->end, pipescout::GoalEnd::kAborted);
  EXPECT_THAT(outcome_->result->sequence, ElementsAre(0, 1, 1));
  harness_.advance(std::chrono::seconds(1));
  EXPECT_EQ(outcome_->end, pipescout::GoalEnd::kSucceeded);
}

TEST_F(FibonacciServerTest, RejectsWhatDoesNotFit) {
  send(46);
  EXPECT_FALSE(accepted_);
  send(0);
  EXPECT_FALSE(accepted_);
}

TEST_F(FibonacciServerTest, StopsWithItsComponent) {
  send(9);
  ASSERT_TRUE(harness_.deactivate(server_).success);
  ASSERT_TRUE(outcome_);
  EXPECT_EQ(outcome_->end, pipescout::GoalEnd::kAborted);
}

}  // namespace
