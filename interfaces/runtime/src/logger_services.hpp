// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <rcl_interfaces/srv/get_logger_levels.hpp>
#include <rcl_interfaces/srv/set_logger_levels.hpp>

#include "pipescout/runtime/node.hpp"

namespace pipescout {

/// The services by which the log level of a node is read and set while it runs, with the names and
/// types that rclcpp has from Iron on: `~/get_logger_levels`, `~/set_logger_levels`. A node has one
/// logger, `Logger::name`; another name has the level 0 (unknown), and setting it is refused. They
/// run in the node's default group and work in every lifecycle state.
class LoggerServices {
 public:
  /// The node must outlive it.
  explicit LoggerServices(Node& node);

 private:
  Service<rcl_interfaces::srv::GetLoggerLevels> get_;
  Service<rcl_interfaces::srv::SetLoggerLevels> set_;
};

}  // namespace pipescout
