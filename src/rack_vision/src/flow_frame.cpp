// SPDX-License-Identifier: Apache-2.0
#include "flow_frame.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace pipescout::rack_vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

/// Cosine of 1.1 degrees: pipes that are parallel for the initialisation.
constexpr double kParallel = 0.9998;
/// Steeper pipes do not lie in a rack.
constexpr double kSteepest = 0.5;

bool parallel(const Vector3d& a, const Vector3d& b) {
  return std::abs(a.dot(b)) > kParallel;
}

/// Turns `direction` to y, and leaves z up.
SO3 rotation_to_y(const Vector3d& direction) {
  const Vector3d up = (Vector3d::UnitZ() - direction.z() * direction).normalized();
  Matrix3d rows;
  rows << direction.cross(up).transpose(), direction.transpose(), up.transpose();
  return SO3::from_matrix(rows);
}

/// A direction near an axis is that axis: boxes stay along the axes.
Vector3d snapped(const Vector3d& direction) {
  for (const Vector3d& axis : {Vector3d(Vector3d::UnitX()), Vector3d(Vector3d::UnitY())}) {
    if (parallel(direction, axis)) {
      return direction.dot(axis) > 0 ? axis : Vector3d(-axis);
    }
  }
  return direction;
}

geometry::Matrix6d turned(const Matrix3d& rotation, const geometry::Matrix6d& covariance) {
  geometry::Matrix6d both = geometry::Matrix6d::Zero();
  both.topLeftCorner<3, 3>() = rotation;
  both.bottomRightCorner<3, 3>() = rotation;
  return both * covariance * both.transpose();
}

RackModel turned(const SO3& rotation, const RackModel& model) {
  RackModel result = model;
  for (Pipe& pipe : result.pipes) {
    pipe.start = rotation * pipe.start;
    pipe.direction = (rotation * pipe.direction).normalized();
    pipe.movable = false;
  }
  for (Support& support : result.supports) {
    const Vector3d one = rotation * support.lowest_corner;
    const Vector3d other = rotation * support.highest_corner;
    support.lowest_corner = one.cwiseMin(other);
    support.highest_corner = one.cwiseMax(other);
  }
  return result;
}

}  // namespace

Vector3d main_direction(const RackModel& model) {
  struct Group {
    Vector3d direction = Vector3d::UnitY();
    std::size_t pipes = 0;
    double length = 0;
  };
  Group best;
  const auto better = [](const Group& a, const Group& b) {
    return a.pipes != b.pipes ? a.pipes > b.pipes : a.length > b.length;
  };
  for (const Pipe& pipe : model.pipes) {
    Group group{.direction = pipe.direction};
    for (const Pipe& other : model.pipes) {
      if (parallel(pipe.direction, other.direction)) {
        ++group.pipes;
        group.length += other.length();
      }
    }
    if (std::abs(pipe.direction.z()) > kSteepest) {
      continue;
    }
    // The frame of the rack file says what a rack of several rows is.
    if (group.pipes >= 2 && parallel(pipe.direction, Vector3d::UnitY())) {
      return Vector3d::UnitY();
    }
    if (better(group, best)) {
      best = group;
    }
  }
  const Vector3d direction = snapped(best.direction);
  return parallel(direction, Vector3d::UnitY()) ? Vector3d(Vector3d::UnitY()) : direction;
}

FlowFrame::FlowFrame(const RackModel& model) : model_(model) {
  const Vector3d direction = main_direction(model);
  if (direction == Vector3d::UnitY()) {
    return;
  }
  if (!model.supports.empty() && std::abs(direction.x()) != 1) {
    throw InvalidRack(InvalidRack::Part::kSupport, 0,
                      "support 0 '" + model.supports[0].name +
                          "': the pipes run obliquely in the rack frame, and supports are boxes "
                          "along its axes; give the rack in a frame whose y is along the pipes");
  }
  R_flow_rack_ = rotation_to_y(direction);
  model_ = turned(*R_flow_rack_, model);
}

SE3 FlowFrame::from_rack(const SE3& T_rack_camera) const {
  return R_flow_rack_ ? SE3(*R_flow_rack_, Vector3d::Zero()) * T_rack_camera : T_rack_camera;
}

SE3 FlowFrame::to_rack(const SE3& T_flow_camera) const {
  return R_flow_rack_ ? SE3(R_flow_rack_->inverse(), Vector3d::Zero()) * T_flow_camera
                      : T_flow_camera;
}

geometry::Matrix6d FlowFrame::from_rack(const geometry::Matrix6d& covariance) const {
  return R_flow_rack_ ? turned(R_flow_rack_->matrix(), covariance) : covariance;
}

geometry::Matrix6d FlowFrame::to_rack(const geometry::Matrix6d& covariance) const {
  return R_flow_rack_ ? turned(R_flow_rack_->matrix().transpose(), covariance) : covariance;
}

FirstPoseHint FlowFrame::from_rack(const FirstPoseHint& hint) const {
  if (!R_flow_rack_) {
    return hint;
  }
  FirstPoseHint result;
  result.z = hint.z;
  const Vector3d x_axis = *R_flow_rack_ * Vector3d::UnitX();
  result.heading = hint.heading;
  if (result.heading) {
    result.heading->value += std::atan2(x_axis.y(), x_axis.x());
  }
  if (std::abs(x_axis.y()) > kParallel) {  // along the other axis
    const double sign = x_axis.y() > 0 ? 1 : -1;
    if (hint.x) {
      result.y = {sign * hint.x->value, hint.x->standard_deviation};
    }
    if (hint.y) {
      result.x = {-sign * hint.y->value, hint.y->standard_deviation};
    }
  } else if (hint.x && hint.y) {
    const Vector3d place = *R_flow_rack_ * Vector3d(hint.x->value, hint.y->value, 0);
    const double deviation = std::max(hint.x->standard_deviation, hint.y->standard_deviation);
    result.x = {place.x(), deviation};
    result.y = {place.y(), deviation};
  }
  return result;
}

}  // namespace pipescout::rack_vision
