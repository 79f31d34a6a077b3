// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <sensor_msgs/msg/joint_state.hpp>
#include <std_msgs/msg/string.hpp>
#include <string>

#include "pipescout/manipulation/robot_tree.hpp"
#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/transform_broadcaster.hpp"

namespace pipescout {

/// What robot_state_publisher is in ROS: tells the description of a robot on `robot_description`,
/// on `tf_static` where its fixed joints put links, and at each `joint_states` on `tf` where the
/// others do.
///
/// Parameters and faults: docs/components/robot_description.md. Parameters take effect when it is
/// configured.
class RobotDescription final : public Component {
 public:
  explicit RobotDescription(ComponentOptions options);

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_cleanup() override;

 private:
  using JointState = sensor_msgs::msg::JointState;

  void on_joint_states(const JointState& message);
  [[nodiscard]] geometry_msgs::msg::TransformStamped stamped(
      const manipulation::LinkTransform& link, const builtin_interfaces::msg::Time& stamp) const;

  Parameter<std::string> urdf_file_;
  Parameter<std::string> frame_prefix_;

  // As configured.
  std::string prefix_;
  std::optional<manipulation::RobotTree> tree_;

  Publisher<std_msgs::msg::String> description_publisher_;
  std::optional<StaticTransformBroadcaster> fixed_;
  std::optional<TransformBroadcaster> moving_;
  Subscription<JointState> joint_subscription_;
};

}  // namespace pipescout
