// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "pipescout/bags/bag_types.hpp"
#include "pipescout/idl/message_type.hpp"
#include "pipescout/runtime/qos.hpp"

namespace pipescout {

/// The definition of a type as MCAP's encoding "ros2msg" has it: the lines of its .msg file, then
/// those of every type within it, each behind a line of '=' and "MSG: package/Type".
[[nodiscard]] std::string ros2msg_schema(const MessageType& type);

/// What a bag keeps of a topic. `type` is a ROS name; the definition is there if the type is one of
/// this installation. `offered`: what its publishers offer.
[[nodiscard]] bags::BagTopic make_bag_topic(const std::string& name, const std::string& type,
                                            std::span<const QoS> offered);

}  // namespace pipescout
