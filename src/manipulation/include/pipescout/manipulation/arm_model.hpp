// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/geometry/se3.hpp"

/// Kinematics of a serial arm that carries a camera. SI units and radians. Frames: `base` is the
/// first link of the chain, x forward, y left, z up (REP 103); `camera` is the optical frame of the
/// camera (x right, y down, z forward).
namespace pipescout::manipulation {

inline constexpr int kMostJoints = 8;
/// One entry per joint, from the base to the camera. Allocates nothing.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostJoints, 1>;
/// 6 x joints. Rows as geometry::SE3's tangents: [linear, m/s; angular, rad/s] per rad/s.
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMostJoints>;

/// A revolute joint, or a continuous one, whose limits are infinite.
struct ArmJoint {
  std::string name;
  double lower = 0;     ///< rad
  double upper = 0;     ///< rad, > lower
  double velocity = 0;  ///< rad/s, > 0: largest
};

/// Distances of the bodies of the arm, m; negative where they overlap. Infinite without an
/// obstacle.
struct Clearance {
  double self = 0;   ///< the smallest between two links that are not adjacent
  double plane = 0;  ///< of the moving links from the plane of the ground
};

/// For what a robot description may leave open.
struct ArmModelOptions {
  /// m, [0, 10]: a mesh, whose content is not read, is taken for capsules of this radius from the
  /// link's frame to those of the joints that it carries. 0: meshes are refused.
  double mesh_radius = 0;
  /// rad/s, (0, 100]: largest rate of continuous joints without a velocity limit.
  double continuous_velocity = 1;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// An arm described by a URDF: the chain of joints between two of its links.
///
/// Bodies are the links' collision geometry: spheres, and cylinders, which are rounded to capsules
/// (half a sphere at each end, beyond the cylinder's length), boxes, which are taken for the
/// capsule along their longest side that contains them, and meshes by `ArmModelOptions`. Links
/// fixed to each other are one body. The kinematics are those of Orocos KDL. Nothing allocates
/// after construction. Not for use by several threads at once.
class ArmModel {
 public:
  /// `urdf`: the text of a robot description. Throws std::invalid_argument naming the link or
  /// joint: the text is not a robot description, a link is missing, the camera is not a descendant
  /// of the base, a joint of the chain is neither fixed, revolute nor continuous, is revolute
  /// without position or velocity limits or mimics another, there are no joints or more than
  /// `kMostJoints`, or a body is a mesh without `mesh_radius`.
  ArmModel(std::string_view urdf, const std::string& base_link, const std::string& camera_link,
           const ArmModelOptions& options = {});
  ArmModel(ArmModel&&) noexcept;
  ArmModel& operator=(ArmModel&&) noexcept;
  ~ArmModel();

  [[nodiscard]] const std::vector<ArmJoint>& joints() const noexcept;
  [[nodiscard]] Eigen::Index size() const noexcept;  ///< number of joints
  /// m: no point of a body is ever farther than this from the axis of a joint that moves it.
  [[nodiscard]] double reach() const noexcept;

  // `q`: rad, one per joint, not checked against the limits. Each throws std::invalid_argument when
  // its size is wrong or an angle is not finite.

  [[nodiscard]] geometry::SE3 T_base_camera(const JointVector& q) const;
  /// Jacobian of the camera's velocity relative to the base: of its origin and its rotation, in
  /// axes of the camera.
  [[nodiscard]] Jacobian camera_jacobian(const JointVector& q) const;
  /// `ground`: m, height of the plane in the base frame.
  [[nodiscard]] Clearance clearance(const JointVector& q, double ground) const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Yoshikawa's measure sqrt(det(J J^T)): 0 in singular postures (Yoshikawa, Manipulability of
/// Robotic Mechanisms, 1985). 0 for arms of fewer than 6 joints.
[[nodiscard]] double manipulability(const Jacobian& jacobian) noexcept;

/// The text of a robot description: a ground robot (`base_link`, half-way between its wheels) with
/// an arm of six joints that carries a thermal camera (`camera_optical_frame`). Installed as
/// share/pipescout_manipulation/urdf/camera_arm.urdf.
[[nodiscard]] std::string_view camera_arm_urdf() noexcept;

}  // namespace pipescout::manipulation
