// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <lifecycle_msgs/msg/transition_event.hpp>
#include <lifecycle_msgs/srv/change_state.hpp>
#include <lifecycle_msgs/srv/get_available_states.hpp>
#include <lifecycle_msgs/srv/get_available_transitions.hpp>
#include <lifecycle_msgs/srv/get_state.hpp>
#include <memory>

#include "pipescout/runtime/component.hpp"

namespace pipescout {

/// What `ros2 lifecycle` talks to: the five services of a managed node, and its topic
/// `~/transition_event`. All run in the component's default group, so none of them sees a
/// transition half done, and they work in every state.
class LifecycleServices {
 public:
  /// The component must outlive it.
  explicit LifecycleServices(Component& component);
  LifecycleServices(const LifecycleServices&) = delete;
  LifecycleServices& operator=(const LifecycleServices&) = delete;
  ~LifecycleServices();

  /// Tells everybody that the component went along an edge. Thread-safe.
  void publish_transition(const LifecycleEdge& edge);

 private:
  class Requests;

  Component& component_;
  Publisher<lifecycle_msgs::msg::TransitionEvent> events_;
  std::shared_ptr<Requests> requests_;
  Service<lifecycle_msgs::srv::ChangeState> change_state_;
  Service<lifecycle_msgs::srv::GetState> get_state_;
  Service<lifecycle_msgs::srv::GetAvailableStates> get_available_states_;
  Service<lifecycle_msgs::srv::GetAvailableTransitions> get_available_transitions_;
  Service<lifecycle_msgs::srv::GetAvailableTransitions> get_transition_graph_;
};

}  // namespace pipescout
