// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unique_identifier_msgs/msg/uuid.hpp>

#include "pipescout/idl/action_type.hpp"
#include "pipescout/idl/field_access.hpp"

/// What servers and clients of actions have in common. An action is, as in ROS 2 Humble, three
/// services and two topics below its name: `_action/send_goal`, `_action/cancel_goal`,
/// `_action/get_result`, `_action/feedback`, `_action/status`.
namespace pipescout {

/// Names a goal: 16 random bytes (a UUID of version 4), chosen by the client.
struct GoalId {
  std::array<std::uint8_t, 16> bytes{};
  auto operator<=>(const GoalId&) const = default;

  /// All zero: names no goal; in a request to cancel it stands for every goal.
  [[nodiscard]] bool is_zero() const noexcept { return *this == GoalId{}; }
  /// Thread-safe. Throws std::system_error when the operating system has no random numbers.
  [[nodiscard]] static GoalId random();
};

/// 32 hexadecimal digits, as `ros2 action` shows a goal.
[[nodiscard]] std::string to_string(const GoalId& id);

[[nodiscard]] unique_identifier_msgs::msg::UUID to_message(const GoalId& id);
[[nodiscard]] GoalId from_message(const unique_identifier_msgs::msg::UUID& message);

/// The state of a goal, with the numbers of action_msgs/msg/GoalStatus.
enum class GoalStatus : std::int8_t {
  kUnknown = 0,
  kAccepted = 1,  ///< deferred: nobody works on it yet
  kExecuting = 2,
  kCanceling = 3,
  kSucceeded = 4,
  kCanceled = 5,
  kAborted = 6
};

/// "accepted"; "unknown" for every number that is none of the above.
[[nodiscard]] std::string_view to_string(GoalStatus status) noexcept;

/// Accepted, executing or canceling: it has not ended.
[[nodiscard]] bool is_active(GoalStatus status) noexcept;

enum class GoalEvent : std::uint8_t { kExecute, kRequestCancel, kSucceed, kAbort, kCancel };

/// The state after an event, or nothing when the event is not possible in that state. The rules of
/// rcl_action, and one more: a goal that nobody executes yet may be aborted.
[[nodiscard]] std::optional<GoalStatus> next_status(GoalStatus status, GoalEvent event) noexcept;

/// The wire types of an action. All pointers are to types that live as long as the process.
struct ActionTypes {
  std::string_view name;  ///< "nav2_msgs/action/NavigateToPose"
  const MessageType* send_goal_request = nullptr;
  const MessageType* send_goal_response = nullptr;
  const MessageType* get_result_request = nullptr;
  const MessageType* get_result_response = nullptr;
  const MessageType* feedback_message = nullptr;
};

template <ActionTag A>
[[nodiscard]] ActionTypes action_types() {
  using Type = ActionType<A>;
  return {.name = Type::action_name,
          .send_goal_request = &message_type<typename Type::SendGoal::Request>(),
          .send_goal_response = &message_type<typename Type::SendGoal::Response>(),
          .get_result_request = &message_type<typename Type::GetResult::Request>(),
          .get_result_response = &message_type<typename Type::GetResult::Response>(),
          .feedback_message = &message_type<typename Type::FeedbackMessage>()};
}

/// The types of an action known by its name, "nav2_msgs/action/NavigateToPose", built in or of an
/// installed package. Throws MessageTypeError.
[[nodiscard]] ActionTypes load_action_types(std::string_view name);

// The part of a wire message that the definition of the action describes. Each throws
// std::invalid_argument when the type has no such part, as those of an action all have.

/// Of a send_goal request, to be filled.
[[nodiscard]] void* goal_in(const ActionTypes& types, void* send_goal_request);
[[nodiscard]] MessageView goal_in(const ActionTypes& types, const void* send_goal_request);
[[nodiscard]] MessageView result_in(const ActionTypes& types, const void* get_result_response);
[[nodiscard]] MessageView feedback_in(const ActionTypes& types, const void* feedback_message);

/// "/robot/navigate_to_pose" + "send_goal" -> "/robot/navigate_to_pose/_action/send_goal".
[[nodiscard]] std::string action_part_name(std::string_view action, std::string_view part);

}  // namespace pipescout
