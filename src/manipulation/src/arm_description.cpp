// SPDX-License-Identifier: Apache-2.0
#include "arm_description.hpp"

#include <urdf_model/model.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

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

ArmJoint limits_of(const urdf::Joint& joint, const ArmModelOptions& options) {
  const std::string name = "joint '" + joint.name + "'";
  if (joint.type != urdf::Joint::REVOLUTE && joint.type != urdf::Joint::CONTINUOUS) {
    refuse(name, ": is neither fixed, revolute nor continuous");
  }
  if (joint.mimic) {
    refuse(name, ": mimics joint '" + joint.mimic->joint_name + "'");
  }
  if (!(eigen(vector(joint.axis)).norm() > 0)) {
    refuse(name, ": has no axis");
  }
  if (joint.type == urdf::Joint::CONTINUOUS) {
    constexpr double kUnlimited = std::numeric_limits<double>::infinity();
    const double velocity = joint.limits ? joint.limits->velocity : 0;
    return {.name = joint.name,
            .lower = -kUnlimited,
            .upper = kUnlimited,
            .velocity =
                velocity > 0 && std::isfinite(velocity) ? velocity : options.continuous_velocity};
  }
  if (!joint.limits) {
    refuse(name, ": has no limits");
  }
  const urdf::JointLimits& limits = *joint.limits;
  if (!(std::isfinite(limits.lower) && std::isfinite(limits.upper) &&
        limits.lower < limits.upper)) {
    refuse(name, ": has no position limits: lower ", limits.lower, ", upper ", limits.upper);
  }
  if (!(limits.velocity > 0 && std::isfinite(limits.velocity))) {
    refuse(name, ": has no velocity limit: velocity ", limits.velocity);
  }
  return {.name = joint.name,
          .lower = limits.lower,
          .upper = limits.upper,
          .velocity = limits.velocity};
}

/// Along the longest side, around the rectangle of the two others.
Capsule capsule_around(const urdf::Box& box, const KDL::Frame& at) {
  const Eigen::Vector3d half = eigen(vector(box.dim)) / 2;
  Eigen::Index longest = 0;
  half.maxCoeff(&longest);
  Eigen::Vector3d across = half;
  across[longest] = 0;
  const Eigen::Vector3d along = half - across;
  const KDL::Vector end(along.x(), along.y(), along.z());
  return {.from = eigen(at * -end), .to = eigen(at * end), .radius = across.norm()};
}

/// From the link's frame to those of the joints that it carries.
std::vector<Capsule> mesh_capsules(const urdf::Link& link, double radius) {
  if (!(radius > 0)) {
    refuse(
        "link '", link.name,
        "': a body for collisions is a mesh, which needs a mesh_radius, or a sphere, cylinder or "
        "box in its place");
  }
  std::vector<Capsule> capsules;
  const Eigen::Vector3d from = Eigen::Vector3d::Zero();
  for (const auto& joint : link.child_joints) {
    const auto& to = joint->parent_to_joint_origin_transform.position;
    capsules.push_back({.from = from, .to = eigen(vector(to)), .radius = radius});
  }
  if (capsules.empty()) {
    capsules.push_back({.from = from, .to = from, .radius = radius});
  }
  return capsules;
}

Capsule capsule_of(const urdf::Collision& collision, const std::string& link) {
  const auto check = [&link](const char* size, double value) {
    if (!(value >= 0 && std::isfinite(value))) {
      refuse("link '", link, "': a body has the ", size, " ", value);
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
  if (const auto* box = dynamic_cast<const urdf::Box*>(collision.geometry.get())) {
    check("side", std::min({box->dim.x, box->dim.y, box->dim.z}));
    check("side", std::max({box->dim.x, box->dim.y, box->dim.z}));
    return capsule_around(*box, at);
  }
  refuse("link '", link, "': a body for collisions has no shape");
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
                         const std::string& camera_link, const ArmModelOptions& options) {
  options.validate();
  const urdf::ModelInterfaceSharedPtr robot = parse_urdf(urdf);
  ArmDescription arm;
  const auto add_bodies = [&](const urdf::Link& link) {
    bool has_mesh = false;
    const auto add = [&arm](const Capsule& capsule) {
      arm.bodies.push_back({.segment = arm.chain.getNrOfSegments(),
                            .joint = static_cast<int>(arm.joints.size()),
                            .capsule = capsule});
    };
    for (const auto& collision : link.collision_array) {
      const bool is_mesh = collision->geometry && collision->geometry->type == urdf::Geometry::MESH;
      has_mesh = has_mesh || is_mesh;
      if (!is_mesh) {
        add(capsule_of(*collision, link.name));
      }
    }
    if (has_mesh) {
      std::ranges::for_each(mesh_capsules(link, options.mesh_radius), add);
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
      arm.joints.push_back(limits_of(joint, options));
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
