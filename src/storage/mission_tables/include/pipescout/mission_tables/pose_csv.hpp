// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>

#include "pipescout/csv/csv_line.hpp"
#include "pipescout/csv/csv_stamp.hpp"
#include "pipescout/geometry/se3.hpp"

/// Poses in data files: the same columns in every subject. Pure.
namespace pipescout {

/// Names of the degrees of freedom of a pose in the order of ROS covariances: the rotations are
/// about the fixed axes.
inline constexpr std::array kPoseAxes{"x", "y", "z", "rotation_x", "rotation_y", "rotation_z"};

/// "stamp,x,y,z,qx,qy,qz,qw,roll,pitch,yaw": m and rad, R = Rz(yaw) Ry(pitch) Rx(roll).
[[nodiscard]] std::string pose_csv_header();
[[nodiscard]] CsvLine pose_csv_line(Stamp stamp, const geometry::SE3& pose);

/// The same, then NAME_standard_deviation for each of `kPoseAxes`, then NAME_NAME_correlation for
/// each pair.
[[nodiscard]] std::string uncertain_pose_csv_header();
/// `covariance`: over `kPoseAxes`, m and rad; its diagonal is above 0. Not checked.
[[nodiscard]] CsvLine uncertain_pose_csv_line(Stamp stamp, const geometry::SE3& pose,
                                              const geometry::Matrix6d& covariance);

}  // namespace pipescout
