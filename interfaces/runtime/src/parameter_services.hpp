// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <rcl_interfaces/msg/parameter_event.hpp>
#include <rcl_interfaces/srv/describe_parameters.hpp>
#include <rcl_interfaces/srv/get_parameter_types.hpp>
#include <rcl_interfaces/srv/get_parameters.hpp>
#include <rcl_interfaces/srv/list_parameters.hpp>
#include <rcl_interfaces/srv/set_parameters.hpp>
#include <rcl_interfaces/srv/set_parameters_atomically.hpp>

#include "pipescout/runtime/node.hpp"

namespace pipescout {

/// What `ros2 param` talks to: the six services of a node's parameters, and its part of
/// `/parameter_events`. The services run in the node's default group and work in every lifecycle
/// state. Answers are those of rclcpp: a question about an undeclared parameter gets an empty
/// response, a refused set its reason.
class ParameterServices {
 public:
  /// The node must outlive it.
  explicit ParameterServices(Node& node);
  ParameterServices(const ParameterServices&) = delete;
  ParameterServices& operator=(const ParameterServices&) = delete;
  ~ParameterServices();

 private:
  Node& node_;
  Publisher<rcl_interfaces::msg::ParameterEvent> events_;
  Service<rcl_interfaces::srv::DescribeParameters> describe_;
  Service<rcl_interfaces::srv::GetParameterTypes> get_types_;
  Service<rcl_interfaces::srv::GetParameters> get_;
  Service<rcl_interfaces::srv::ListParameters> list_;
  Service<rcl_interfaces::srv::SetParameters> set_;
  Service<rcl_interfaces::srv::SetParametersAtomically> set_atomically_;
};

}  // namespace pipescout
