// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/action.hpp"

#include <sys/random.h>

#include <cerrno>
#include <memory>
#include <stdexcept>
#include <system_error>

namespace pipescout {

namespace {

const MessageField& part_of(const MessageType& type, std::string_view name) {
  const MessageField* field = find_field(type, name);
  if (field == nullptr || field->kind != FieldKind::kMessage ||
      field->shape != FieldShape::kSingle) {
    throw std::invalid_argument(std::string(type.name) + " has no message '" + std::string(name) +
                                "'");
  }
  return *field;
}

}  // namespace

GoalId GoalId::random() {
  GoalId id;
  // At most 256 bytes are given whole, once the machine has started.
  while (getrandom(id.bytes.data(), id.bytes.size(), 0) != static_cast<ssize_t>(id.bytes.size())) {
    if (errno != EINTR) {
      throw std::system_error(errno, std::generic_category(), "identifier of a goal");
    }
  }
  // RFC 9562, 5.4: version 4 and the variant.
  id.bytes[6] = static_cast<std::uint8_t>((id.bytes[6] & 0x0FU) | 0x40U);
  id.bytes[8] = static_cast<std::uint8_t>((id.bytes[8] & 0x3FU) | 0x80U);
  return id;
}

std::string to_string(const GoalId& id) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : id.bytes) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 0x0FU];
  }
  return text;
}

unique_identifier_msgs::msg::UUID to_message(const GoalId& id) {
  unique_identifier_msgs::msg::UUID message;
  message.uuid = id.bytes;
  return message;
}

GoalId from_message(const unique_identifier_msgs::msg::UUID& message) {
  return {message.uuid};
}

std::string_view to_string(GoalStatus status) noexcept {
  switch (status) {
    case GoalStatus::kAccepted:
      return "accepted";
    case GoalStatus::kExecuting:
      return "executing";
    case GoalStatus::kCanceling:
      return "canceling";
    case GoalStatus::kSucceeded:
      return "succeeded";
    case GoalStatus::kCanceled:
      return "canceled";
    case GoalStatus::kAborted:
      return "aborted";
    case GoalStatus::kUnknown:
      break;
  }
  return "unknown";
}

bool is_active(GoalStatus status) noexcept {
  return status == GoalStatus::kAccepted || status == GoalStatus::kExecuting ||
         status == GoalStatus::kCanceling;
}

std::optional<GoalStatus> next_status(GoalStatus status, GoalEvent event) noexcept {
  const bool works = status == GoalStatus::kExecuting || status == GoalStatus::kCanceling;
  switch (event) {
    case GoalEvent::kExecute:
      return status == GoalStatus::kAccepted ? std::optional(GoalStatus::kExecuting) : std::nullopt;
    case GoalEvent::kRequestCancel:
      return status == GoalStatus::kAccepted || status == GoalStatus::kExecuting
                 ? std::optional(GoalStatus::kCanceling)
                 : std::nullopt;
    case GoalEvent::kSucceed:
      return works ? std::optional(GoalStatus::kSucceeded) : std::nullopt;
    case GoalEvent::kAbort:
      return is_active(status) ? std::optional(GoalStatus::kAborted) : std::nullopt;
    case GoalEvent::kCancel:
      return status == GoalStatus::kCanceling ? std::optional(GoalStatus::kCanceled) : std::nullopt;
  }
  return std::nullopt;
}

ActionTypes load_action_types(std::string_view name) {
  const std::string base(name);
  const MessageType& send_goal_request = load_message_type(base + "_SendGoal_Request");
  constexpr std::string_view kSuffix = "_SendGoal_Request";
  std::string_view own_name = send_goal_request.name;
  own_name.remove_suffix(kSuffix.size());
  return {.name = own_name,
          .send_goal_request = &send_goal_request,
          .send_goal_response = &load_message_type(base + "_SendGoal_Response"),
          .get_result_request = &load_message_type(base + "_GetResult_Request"),
          .get_result_response = &load_message_type(base + "_GetResult_Response"),
          .feedback_message = &load_message_type(base + "_FeedbackMessage")};
}

void* goal_in(const ActionTypes& types, void* send_goal_request) {
  return FieldEditor(part_of(*types.send_goal_request, "goal"), send_goal_request).message(0);
}

MessageView goal_in(const ActionTypes& types, const void* send_goal_request) {
  return FieldView(part_of(*types.send_goal_request, "goal"), send_goal_request).message();
}

MessageView result_in(const ActionTypes& types, const void* get_result_response) {
  return FieldView(part_of(*types.get_result_response, "result"), get_result_response).message();
}

MessageView feedback_in(const ActionTypes& types, const void* feedback_message) {
  return FieldView(part_of(*types.feedback_message, "feedback"), feedback_message).message();
}

std::string action_part_name(std::string_view action, std::string_view part) {
  return std::string(action) + "/_action/" + std::string(part);
}

}  // namespace pipescout
