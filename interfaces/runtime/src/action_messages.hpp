// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <builtin_interfaces/msg/time.hpp>
#include <cstddef>
#include <memory>
#include <string_view>

#include "pipescout/runtime/action.hpp"

namespace pipescout {

/// Reads and writes the fields that every action's wire messages have, whatever its definition.
class ActionMessages {
 public:
  /// Throws std::invalid_argument when a type does not have them.
  explicit ActionMessages(const ActionTypes& types);

  [[nodiscard]] const ActionTypes& types() const noexcept { return types_; }

  [[nodiscard]] GoalId id_of_goal_request(const void* message) const;
  void set_id_of_goal_request(void* message, const GoalId& id) const;
  [[nodiscard]] std::shared_ptr<const void> goal_response(
      bool accepted, const builtin_interfaces::msg::Time& stamp) const;
  [[nodiscard]] bool is_accepted(const void* goal_response) const;
  [[nodiscard]] builtin_interfaces::msg::Time stamp_of(const void* goal_response) const;

  [[nodiscard]] std::shared_ptr<const void> result_request(const GoalId& id) const;
  [[nodiscard]] GoalId id_of_result_request(const void* message) const;
  /// With the default of each field but the status.
  [[nodiscard]] std::shared_ptr<void> result_response(GoalStatus status) const;
  void set_status(void* result_response, GoalStatus status) const;
  [[nodiscard]] GoalStatus status_of(const void* result_response) const;

  [[nodiscard]] GoalId id_of_feedback(const void* message) const;
  void set_id_of_feedback(void* message, const GoalId& id) const;

 private:
  ActionTypes types_;
  std::size_t goal_request_id_;
  std::size_t accepted_;
  std::size_t stamp_;
  std::size_t result_request_id_;
  std::size_t status_;
  std::size_t feedback_id_;
};

}  // namespace pipescout
