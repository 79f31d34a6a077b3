// SPDX-License-Identifier: Apache-2.0
#include "action_messages.hpp"

#include <cstdint>
#include <stdexcept>
#include <string>

namespace pipescout {

namespace {

using TimeMessage = builtin_interfaces::msg::Time;
using unique_identifier_msgs::msg::UUID;

std::size_t offset_of(const MessageType& type, std::string_view name, FieldKind kind,
                      std::string_view message = {}) {
  const MessageField* field = find_field(type, name);
  if (field == nullptr || field->kind != kind || field->shape != FieldShape::kSingle ||
      (kind == FieldKind::kMessage && field->message().name != message)) {
    throw std::invalid_argument(std::string(type.name) + ": no part of an action, its field '" +
                                std::string(name) + "' is missing or of another type");
  }
  return field->offset;
}

std::size_t id_offset(const MessageType& type) {
  return offset_of(type, "goal_id", FieldKind::kMessage, message_type<UUID>().name);
}

template <class Field>
Field& at(void* message, std::size_t offset) {
  return *reinterpret_cast<Field*>(static_cast<std::byte*>(message) + offset);
}
template <class Field>
const Field& at(const void* message, std::size_t offset) {
  return *reinterpret_cast<const Field*>(static_cast<const std::byte*>(message) + offset);
}

}  // namespace

ActionMessages::ActionMessages(const ActionTypes& types)
    : types_(types),
      goal_request_id_(id_offset(*types.send_goal_request)),
      accepted_(offset_of(*types.send_goal_response, "accepted", FieldKind::kBool)),
      stamp_(offset_of(*types.send_goal_response, "stamp", FieldKind::kMessage,
                       message_type<TimeMessage>().name)),
      result_request_id_(id_offset(*types.get_result_request)),
      status_(offset_of(*types.get_result_response, "status", FieldKind::kInt8)),
      feedback_id_(id_offset(*types.feedback_message)) {}

GoalId ActionMessages::id_of_goal_request(const void* message) const {
  return from_message(at<UUID>(message, goal_request_id_));
}
void ActionMessages::set_id_of_goal_request(void* message, const GoalId& id) const {
  at<UUID>(message, goal_request_id_) = to_message(id);
}

std::shared_ptr<const void> ActionMessages::goal_response(bool accepted,
                                                          const TimeMessage& stamp) const {
  const std::shared_ptr<void> message = types_.send_goal_response->create();
  at<bool>(message.get(), accepted_) = accepted;
  at<TimeMessage>(message.get(), stamp_) = stamp;
  return message;
}
bool ActionMessages::is_accepted(const void* goal_response) const {
  return at<bool>(goal_response, accepted_);
}
TimeMessage ActionMessages::stamp_of(const void* goal_response) const {
  return at<TimeMessage>(goal_response, stamp_);
}

std::shared_ptr<const void> ActionMessages::result_request(const GoalId& id) const {
  const std::shared_ptr<void> message = types_.get_result_request->create();
  at<UUID>(message.get(), result_request_id_) = to_message(id);
  return message;
}
GoalId ActionMessages::id_of_result_request(const void* message) const {
  return from_message(at<UUID>(message, result_request_id_));
}

std::shared_ptr<void> ActionMessages::result_response(GoalStatus status) const {
  std::shared_ptr<void> message = types_.get_result_response->create();
  set_status(message.get(), status);
  return message;
}
void ActionMessages::set_status(void* result_response, GoalStatus status) const {
  at<std::int8_t>(result_response, status_) = static_cast<std::int8_t>(status);
}
GoalStatus ActionMessages::status_of(const void* result_response) const {
  return static_cast<GoalStatus>(at<std::int8_t>(result_response, status_));
}

GoalId ActionMessages::id_of_feedback(const void* message) const {
  return from_message(at<UUID>(message, feedback_id_));
}
void ActionMessages::set_id_of_feedback(void* message, const GoalId& id) const {
  at<UUID>(message, feedback_id_) = to_message(id);
}

}  // namespace pipescout
