// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/action.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <example_interfaces/action/fibonacci.hpp>
#include <map>
#include <optional>
#include <set>
#include <std_srvs/srv/trigger.hpp>
#include <stdexcept>
#include <utility>

#include "action_messages.hpp"

namespace pipescout {
namespace {

using example_interfaces::action::Fibonacci;

TEST(GoalIdentifier, IsRandomAndAUuidOfVersion4) {
  std::set<GoalId> seen;
  for (int i = 0; i < 1000; ++i) {
    const GoalId id = GoalId::random();
    EXPECT_TRUE(seen.insert(id).second);
    EXPECT_EQ(id.bytes[6] >> 4U, 4);
    EXPECT_EQ(id.bytes[8] >> 6U, 2);
  }
}

TEST(GoalIdentifier, GoesToTheWireAndIsShownInHexadecimal) {
  GoalId id;
  EXPECT_TRUE(id.is_zero());
  EXPECT_EQ(to_string(id), "00000000000000000000000000000000");
  for (std::size_t i = 0; i < id.bytes.size(); ++i) {
    id.bytes[i] = static_cast<std::uint8_t>(0x1F * i);
  }
  EXPECT_FALSE(id.is_zero());
  EXPECT_EQ(to_string(id), "001f3e5d7c9bbad9f81736557493b2d1");
  EXPECT_EQ(from_message(to_message(id)), id);
}

TEST(GoalStates, OnlyTheTransitionsOfRclActionArePossible) {
  using S = GoalStatus;
  using E = GoalEvent;
  const std::map<std::pair<S, E>, S> possible{
      {{S::kAccepted, E::kExecute}, S::kExecuting},
      {{S::kAccepted, E::kRequestCancel}, S::kCanceling},
      {{S::kAccepted, E::kAbort}, S::kAborted},  // not in rcl_action: a goal nobody came to
      {{S::kExecuting, E::kRequestCancel}, S::kCanceling},
      {{S::kExecuting, E::kSucceed}, S::kSucceeded},
      {{S::kExecuting, E::kAbort}, S::kAborted},
      {{S::kCanceling, E::kSucceed}, S::kSucceeded},
      {{S::kCanceling, E::kAbort}, S::kAborted},
      {{S::kCanceling, E::kCancel}, S::kCanceled},
  };
  for (int status = -1; status <= 7; ++status) {
    for (const E event : {E::kExecute, E::kRequestCancel, E::kSucceed, E::kAbort, E::kCancel}) {
      const auto from = static_cast<S>(status);
      const auto found = possible.find({from, event});
      EXPECT_EQ(next_status(from, event),
                found == possible.end() ? std::nullopt : std::optional(found->second))
          << status << ' ' << static_cast<int>(event);
    }
  }
}

TEST(GoalStates, HaveNamesAndAreActiveOrNot) {
  const std::array names{"unknown",   "accepted", "executing", "canceling",
                         "succeeded", "canceled", "aborted"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto status = static_cast<GoalStatus>(i);
    EXPECT_EQ(to_string(status), names[i]);
    EXPECT_EQ(is_active(status), i >= 1 && i <= 3) << names[i];
  }
  EXPECT_EQ(to_string(static_cast<GoalStatus>(99)), "unknown");
}

TEST(ActionTypesByName, AreThoseOfTheTag) {
  const ActionTypes typed = action_types<Fibonacci>();
  const ActionTypes loaded = load_action_types("example_interfaces/action/Fibonacci");
  EXPECT_EQ(loaded.name, "example_interfaces/action/Fibonacci");
  EXPECT_EQ(loaded.name, typed.name);
  EXPECT_EQ(loaded.send_goal_request, typed.send_goal_request);
  EXPECT_EQ(loaded.send_goal_response, typed.send_goal_response);
  EXPECT_EQ(loaded.get_result_request, typed.get_result_request);
  EXPECT_EQ(loaded.get_result_response, typed.get_result_response);
  EXPECT_EQ(loaded.feedback_message, typed.feedback_message);
  EXPECT_THROW(static_cast<void>(load_action_types("example_interfaces/action/Nothing")),
               MessageTypeError);
  EXPECT_THROW(static_cast<void>(load_action_types("")), MessageTypeError);
}

TEST(ActionTypesByName, FindThePartsThatTheDefinitionDescribes) {
  const ActionTypes types = action_types<Fibonacci>();
  Fibonacci::Impl::SendGoalService::Request request;
  static_cast<Fibonacci::Goal*>(goal_in(types, &request))->order = 7;
  EXPECT_EQ(request.goal.order, 7);
  const MessageView goal = goal_in(types, static_cast<const void*>(&request));
  EXPECT_EQ(goal.type->name, "example_interfaces/action/Fibonacci_Goal");
  EXPECT_EQ(goal.message, &request.goal);
  const Fibonacci::Impl::GetResultService::Response response;
  EXPECT_EQ(result_in(types, &response).message, &response.result);
  const Fibonacci::Impl::FeedbackMessage feedback;
  EXPECT_EQ(feedback_in(types, &feedback).message, &feedback.feedback);
}

TEST(ActionWireMessages, OfAnotherKindAreRefused) {
  ActionTypes types = action_types<Fibonacci>();
  types.send_goal_response = &message_type<std_srvs::srv::Trigger::Response>();
  EXPECT_THROW(ActionMessages{types}, std::invalid_argument);
  types = action_types<Fibonacci>();
  types.feedback_message = &message_type<Fibonacci::Feedback>();
  EXPECT_THROW(ActionMessages{types}, std::invalid_argument);
  EXPECT_THROW(static_cast<void>(feedback_in(types, nullptr)), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout
