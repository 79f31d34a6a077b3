// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <string_view>

#include "pipescout/idl/service_type.hpp"

namespace pipescout {

/// The parts of an action. `A` is the tag that the action's generated header declares, such as
/// `nav2_msgs::action::NavigateToPose` in <nav2_msgs/action/navigate_to_pose.hpp>; each such header
/// specialises this with
///   using Goal, using Result, using Feedback      as in its definition
///   using FeedbackMessage                         the feedback with the identifier of its goal
///   using SendGoal, using GetResult               tags of the services under the action's name
///   static constexpr std::string_view action_name     "nav2_msgs/action/NavigateToPose"
template <class A>
struct ActionType;

/// The tag of an action, whose header is included.
template <class A>
concept ActionTag = requires {
  requires Message<typename ActionType<A>::Goal>;
  requires Message<typename ActionType<A>::Result>;
  requires Message<typename ActionType<A>::Feedback>;
  requires Message<typename ActionType<A>::FeedbackMessage>;
  requires ServiceTag<typename ActionType<A>::SendGoal>;
  requires ServiceTag<typename ActionType<A>::GetResult>;
  { ActionType<A>::action_name } -> std::convertible_to<std::string_view>;
};

}  // namespace pipescout
