// SPDX-License-Identifier: Apache-2.0
#include "arm_description.hpp"

#include <urdf_model/model.h>

#include <algorithm>
#include <cmath>

#include "pipescout/validation/check.hpp"
#include "urdf_text.hpp"

namespace pipescout::manipulation::internal {
namespace {

using validation::refuse;

KDL::Vector vector(const urdf::Vector3& v) {
  return {v.x, v.y, v.z};
}

KDL::Frame frame(const urdf::Pose& pose) {
  const urdf::Rotation& r = pose.rotation;
  return {KDL::Rotation::Quaternion(r.x, r.y, r.z, r.w), vector(pose.position)};
}

Eigen::Vector3d eigen(const KDL::Vector& v) {
  return {v.x(), v.y(), v.z()};
}

ArmJoint limits_of(const urdf::Joint& joint) {
  const std::string name = "joint '" + joint.name + "'";
  if (joint.type != urdf::Joint::REVOLUTE) {
    refuse(name, ": ",
           joint.type == urdf::Joint::CONTINUOUS ? "is continuous: it has no position limits"
                                                 : "is neither fixed nor revolute");
  }
  if (joint.mimic) {
    refuse(name, ": mimics joint '" + joint.mimic->joint_name + "'");
  }
  if (!joint.limits) {
    refuse(name, ": has no limits");
  }
  const urdf::JointLimits& limits = *joint.limits;
  if (!(std::isfinite(limits.lower) && std::isfinite(limits.upper) &&
        limits.lower < limits.upper)) {
    refuse(name, ": ",
           "has no position limits: lower " + std::to_string(limits.lower) + ", upper " +
               std::to_string(limits.upper));
  }
  if (!(limits.velocity > 0 && std::isfinite(limits.velocity))) {
    refuse(name, ": has no velocity limit: velocity " + std::to_string(limits.velocity));
  }
  if (!(eigen(vector(joint.axis)).norm() > 0)) {
    refuse(name, ": has no axis");
  }
  return {.name = joint.name,
          .lower = limits.lower,
          .upper = limits.upper,
          .velocity = limits.velocity};
}

Capsule capsule_of(const urdf::Collision& collision, const std::string& link) {
  const auto check = [&link](const char* size, double value) {
    if (!(value >= 0 && std::isfinite(value))) {
      refuse("link '", link,
             "': ", std::string("a body has the ") + size + " " + std::to_string(value));
    }
    return value;
  };
  const KDL::Frame at = frame(collision.origin);
  if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(collision.geometry.get())) {
    return {.from = eigen(at.p), .to = eigen(at.p), .radius = check("radius", sphere->radius)};
  }
  if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(collision.geometry.get())) {
    const KDL::Vector half(0, 0, check("length", cylinder->length) / 2);
    return {.from = eigen(at * -half),
            .to = eigen(at * half),
            .radius = check("radius", cylinder->radius)};
  }
  refuse("link '", link, "': a body for collisions is neither a sphere nor a cylinder");
}

/// From the base, without it, to the camera.
std::vector<urdf::LinkConstSharedPtr> links_between(const urdf::ModelInterface& robot,
                                                    const std::string& base_link,
                                                    const std::string& camera_link) {
  for (const std::string& name : {base_link, camera_link}) {
    if (!robot.getLink(name)) {
      refuse("link '", name, "': is not in the robot description '" + robot.getName() + "'");
    }
  }
  std::vector<urdf::LinkConstSharedPtr> links;
  for (urdf::LinkConstSharedPtr link = robot.getLink(camera_link); link->name != base_link;
       link = link->getParent()) {
    links.push_back(link);
    if (!link->getParent()) {
      refuse("link '", camera_link, "': no chain of joints leads to it from '" + base_link + "'");
    }
  }
  std::ranges::reverse(links);
  return links;
}

}  // namespace

ArmDescription parse_arm(std::string_view urdf, const std::string& base_link,
                         const std::string& camera_link) {
  const urdf::ModelInterfaceSharedPtr robot = parse_urdf(urdf);
  ArmDescription arm;
  const auto add_bodies = [&arm](const urdf::Link& link) {
    for (const auto& collision : link.collision_array) {
      arm.bodies.push_back({.segment = arm.chain.getNrOfSegments(),
                            .joint = static_cast<int>(arm.joints.size()),
                            .capsule = capsule_of(*collision, link.name)});
    }
  };
  const auto links = links_between(*robot, base_link, camera_link);
  add_bodies(*robot->getLink(base_link));
  for (const urdf::LinkConstSharedPtr& link : links) {
    const urdf::Joint& joint = *link->parent_joint;
    const KDL::Frame at = frame(joint.parent_to_joint_origin_transform);
    if (joint.type == urdf::Joint::FIXED) {
      arm.chain.addSegment(KDL::Segment(link->name, KDL::Joint(KDL::Joint::Fixed), at));
    } else {
      arm.joints.push_back(limits_of(joint));
      const KDL::Joint turning(joint.name, at.p, at.M * vector(joint.axis), KDL::Joint::RotAxis);
      arm.chain.addSegment(KDL::Segment(link->name, turning, at));
    }
    add_bodies(*link);
  }
  if (arm.joints.empty() || arm.joints.size() > kMostJoints) {
    refuse("link '", camera_link, "': ",
           std::to_string(arm.joints.size()) + " joints lead to it from '" + base_link +
               "', not 1 to " + std::to_string(kMostJoints));
  }
  return arm;
}

}  // namespace pipescout::manipulation::internal
