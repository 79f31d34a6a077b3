// SPDX-License-Identifier: Apache-2.0
#include "pipescout/robot_description/robot_description.hpp"

#include <stdexcept>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/mounting_parameters.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"

namespace pipescout {

RobotDescription::RobotDescription(ComponentOptions options) : Component(std::move(options)) {
  urdf_file_ = parameters().declare<std::string>(
      "urdf_file", "", {.description = "robot description, a URDF file; must be given"});
  frame_prefix_ = parameters().declare<std::string>(
      "frame_prefix", "",
      {.description =
           "what names of links begin with as frames; empty, as each robot has its own tf"});
}

CallbackReturn RobotDescription::on_configure() {
  if (urdf_file_.get().empty()) {
    throw std::invalid_argument("parameter 'urdf_file' is empty: no robot description is given");
  }
  const std::string urdf = file_content(urdf_file_);
  try {
    tree_.emplace(urdf);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("parameter 'urdf_file': " + urdf_file_.get() + ": " + error.what());
  }
  prefix_ = frame_prefix_.get();
  for (const std::string& joint : tree_->left_out()) {
    logger().warn(
        "joint '" + joint +
        "' is planar or floating: joint_states does not say where it is, so somebody else "
        "must send its transform");
  }

  // In every state, as the static transforms are: both say what does not change.
  description_publisher_ = create_publisher(topics::kRobotDescription, {.managed = false});
  std_msgs::msg::String text;
  text.data = urdf;
  description_publisher_.publish(std::move(text));
  fixed_.emplace(*this);
  std::vector<geometry_msgs::msg::TransformStamped> transforms;
  for (const auto& link : tree_->fixed()) {
    transforms.push_back(stamped(link, to_message(now())));
  }
  fixed_->send(std::move(transforms));
  moving_.emplace(*this);
  joint_subscription_ = create_subscription(
      topics::kJointStates, [this](const JointState& message) { on_joint_states(message); });
  return CallbackReturn::kSuccess;
}

CallbackReturn RobotDescription::on_cleanup() {
  joint_subscription_ = {};
  moving_.reset();
  fixed_.reset();
  description_publisher_ = {};
  tree_.reset();
  return CallbackReturn::kSuccess;
}

void RobotDescription::on_joint_states(const JointState& message) {
  std::vector<geometry_msgs::msg::TransformStamped> transforms;
  try {
    for (const auto& link : tree_->moving(message.name, message.position)) {
      transforms.push_back(stamped(link, message.header.stamp));
    }
  } catch (const std::invalid_argument& error) {
    report_fault("joint_states.refused", std::string("joint_states refused: ") + error.what());
    return;
  }
  // Joints of others come on the same topic.
  if (!transforms.empty()) {
    moving_->send(std::move(transforms));
  }
}

geometry_msgs::msg::TransformStamped RobotDescription::stamped(
    const manipulation::LinkTransform& link, const builtin_interfaces::msg::Time& stamp) const {
  geometry_msgs::msg::TransformStamped result;
  result.header.stamp = stamp;
  result.header.frame_id = prefix_ + link.parent;
  result.child_frame_id = prefix_ + link.child;
  result.transform = transform_message(link.T_parent_child);
  return result;
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::RobotDescription)
