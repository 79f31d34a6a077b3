// SPDX-License-Identifier: Apache-2.0
#include "rosout.hpp"

#include <rcl_interfaces/msg/log.hpp>

#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/standard_topics.hpp"

namespace pipescout {

Rosout::Rosout(Node& node) : logger_(node.logger()) {
  auto publisher = node.create_publisher(topics::kRosout, {.managed = false});
  // A log call may outlast the node, so nothing here refers to it. As in ROS 2 the stamp is the
  // time of the system also where the node's time is simulated.
  logger_.set_sink(
      [publisher, clock = node.context().system_clock(), name = logger_.name()](
          LogSeverity severity, const std::string& text, const Logger::Location& where) mutable {
        rcl_interfaces::msg::Log message;
        message.stamp = to_message(clock->now());
        message.level = static_cast<std::uint8_t>(severity);
        message.name = name;
        message.msg = text;
        message.file = where.file_name();
        message.function = where.function_name();
        message.line = where.line();
        publisher.publish(std::move(message));
      });
}

Rosout::~Rosout() {
  logger_.set_sink({});
}

}  // namespace pipescout
