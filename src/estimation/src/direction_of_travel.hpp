// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/estimation/state.hpp"

namespace pipescout::estimation {

/// Rotation from the body to a frame whose x axis is the direction of travel, M^T with
/// M = Rz(yaw) Ry(pitch), and its derivatives by the two angles.
struct DirectionOfTravel {
  explicit DirectionOfTravel(const GlobalStates& globals) {
    const geometry::SO3 unyawed = geometry::SO3::about_z(-globals.mount_yaw);
    const geometry::SO3 unpitched = geometry::SO3::about_y(-globals.mount_pitch);
    R_travel_body = (unpitched * unyawed).matrix();
    by_yaw = -R_travel_body * geometry::skew(Eigen::Vector3d::UnitZ());
    by_pitch = -geometry::skew(Eigen::Vector3d::UnitY()) * R_travel_body;
  }

  Eigen::Matrix3d R_travel_body;
  Eigen::Matrix3d by_yaw;
  Eigen::Matrix3d by_pitch;
};

}  // namespace pipescout::estimation
