// SPDX-License-Identifier: Apache-2.0
#include "pipescout/manipulation/robot_tree.hpp"

#include <cmath>
#include <stdexcept>

#include "urdf_text.hpp"

namespace pipescout::manipulation {
namespace {

using geometry::SE3;
using geometry::SO3;

SE3 origin_of(const urdf::Joint& joint) {
  const urdf::Pose& pose = joint.parent_to_joint_origin_transform;
  const urdf::Rotation& r = pose.rotation;
  try {
    return {SO3::from_quaternion(Eigen::Quaterniond(r.w, r.x, r.y, r.z)),
            {pose.position.x, pose.position.y, pose.position.z}};
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("joint '" + joint.name + "': origin: " + error.what());
  }
}

}  // namespace

RobotTree::RobotTree(std::string_view urdf) {
  const urdf::ModelInterfaceSharedPtr robot = internal::parse_urdf(urdf);
  root_ = robot->getRoot()->name;
  for (const auto& [name, joint] : robot->joints_) {
    LinkTransform transform{joint->parent_link_name, joint->child_link_name, origin_of(*joint)};
    if (joint->type == urdf::Joint::FIXED) {
      fixed_.push_back(std::move(transform));
      continue;
    }
    if (joint->type == urdf::Joint::PLANAR || joint->type == urdf::Joint::FLOATING) {
      left_out_.push_back(name);
      continue;
    }
    const Eigen::Vector3d axis(joint->axis.x, joint->axis.y, joint->axis.z);
    if (!(axis.norm() > 0) || !axis.allFinite()) {
      throw std::invalid_argument("joint '" + name + "': has no axis");
    }
    Joint moving{.at_zero = std::move(transform),
                 .axis = axis.normalized(),
                 .turns = joint->type != urdf::Joint::PRISMATIC};
    std::string moved_by = name;
    if (joint->mimic) {
      moved_by = joint->mimic->joint_name;
      moving.multiplier = joint->mimic->multiplier;
      moving.offset = joint->mimic->offset;
      if (!robot->getJoint(moved_by)) {
        throw std::invalid_argument("joint '" + name + "': mimics joint '" + moved_by +
                                    "', which is not there");
      }
    }
    joints_.emplace(std::move(moved_by), std::move(moving));
  }
}

std::vector<LinkTransform> RobotTree::moving(std::span<const std::string> names,
                                             std::span<const double> positions) const {
  if (names.size() != positions.size()) {
    throw std::invalid_argument(std::to_string(names.size()) + " names of joints and " +
                                std::to_string(positions.size()) + " positions");
  }
  std::vector<LinkTransform> result;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto [begin, end] = joints_.equal_range(names[i]);
    for (auto entry = begin; entry != end; ++entry) {
      const Joint& joint = entry->second;
      const double position = joint.multiplier * positions[i] + joint.offset;
      if (!std::isfinite(position)) {
        throw std::invalid_argument("the position of joint '" + names[i] + "' is not finite");
      }
      LinkTransform moved = joint.at_zero;
      moved.T_parent_child =
          moved.T_parent_child *
          (joint.turns ? SE3(SO3::exp(position * joint.axis), Eigen::Vector3d::Zero())
                       : SE3(SO3(), position * joint.axis));
      result.push_back(std::move(moved));
    }
  }
  return result;
}

}  // namespace pipescout::manipulation
