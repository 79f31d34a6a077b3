// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/transform_broadcaster.hpp"

#include <utility>

#include "pipescout/runtime/standard_topics.hpp"

namespace pipescout {

TransformBroadcaster::TransformBroadcaster(Node& node)
    : publisher_(node.create_publisher(topics::kTf)) {}

void TransformBroadcaster::send(std::vector<geometry_msgs::msg::TransformStamped> transforms) {
  tf2_msgs::msg::TFMessage message;
  message.transforms = std::move(transforms);
  publisher_.publish(std::move(message));
}

void TransformBroadcaster::send(geometry_msgs::msg::TransformStamped transform) {
  std::vector<geometry_msgs::msg::TransformStamped> transforms;
  transforms.push_back(std::move(transform));
  send(std::move(transforms));
}

StaticTransformBroadcaster::StaticTransformBroadcaster(Node& node)
    : publisher_(node.create_publisher(topics::kTfStatic, {.managed = false})) {}

void StaticTransformBroadcaster::send(
    std::vector<geometry_msgs::msg::TransformStamped> transforms) {
  // Published under the lock: a message without the last transform must not overtake one with it.
  const std::lock_guard lock(mutex_);
  for (auto& transform : transforms) {
    std::string child = transform.child_frame_id;
    transforms_.insert_or_assign(std::move(child), std::move(transform));
  }
  tf2_msgs::msg::TFMessage message;
  for (const auto& [child, transform] : transforms_) {
    message.transforms.push_back(transform);
  }
  publisher_.publish(std::move(message));
}

void StaticTransformBroadcaster::send(geometry_msgs::msg::TransformStamped transform) {
  std::vector<geometry_msgs::msg::TransformStamped> transforms;
  transforms.push_back(std::move(transform));
  send(std::move(transforms));
}

}  // namespace pipescout
