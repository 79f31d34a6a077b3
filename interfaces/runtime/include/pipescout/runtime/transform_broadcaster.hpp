// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <geometry_msgs/msg/transform_stamped.hpp>
#include <map>
#include <mutex>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>
#include <vector>

#include "pipescout/runtime/node.hpp"

namespace pipescout {

/// Tells on `tf` where moving frames are. Thread-safe.
class TransformBroadcaster {
 public:
  /// As an endpoint of the node: silent while a component is not active. Throws as
  /// `create_publisher`.
  explicit TransformBroadcaster(Node& node);

  /// All in one message.
  void send(std::vector<geometry_msgs::msg::TransformStamped> transforms);
  void send(geometry_msgs::msg::TransformStamped transform);

 private:
  Publisher<tf2_msgs::msg::TFMessage> publisher_;
};

/// Tells on `tf_static` where frames are that do not move, in every lifecycle state. The topic
/// keeps one message of each publisher for those that come later, so each message has all of the
/// transforms that were sent; hence one broadcaster for a node. Thread-safe.
class StaticTransformBroadcaster {
 public:
  /// Throws as `create_publisher`.
  explicit StaticTransformBroadcaster(Node& node);

  /// Adds them, or replaces those of the same children, and publishes all.
  void send(std::vector<geometry_msgs::msg::TransformStamped> transforms);
  void send(geometry_msgs::msg::TransformStamped transform);

 private:
  std::mutex mutex_;
  std::map<std::string, geometry_msgs::msg::TransformStamped> transforms_;  // by child
  Publisher<tf2_msgs::msg::TFMessage> publisher_;
};

}  // namespace pipescout
