// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <geometry_msgs/msg/pose.hpp>
#include <nav_msgs/msg/occupancy_grid.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <nav_msgs/msg/path.hpp>
#include <optional>
#include <pipescout_msgs/msg/navigator_state.hpp>
#include <pipescout_msgs/msg/pipe_coverage.hpp>
#include <string>
#include <vector>

#include "pipescout/move_base/move_base.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// s since the epoch.
[[nodiscard]] double seconds(Time time);

/// Position and yaw. Throws std::invalid_argument naming the field.
[[nodiscard]] navigation::Pose2d plane_pose(const geometry_msgs::msg::Pose& message);
[[nodiscard]] geometry_msgs::msg::Pose pose_message(const navigation::Pose2d& pose);

/// Throws std::invalid_argument naming the field, also for a covariance that is not stated.
[[nodiscard]] navigation::Localisation localisation(const nav_msgs::msg::Odometry& message);

/// Centres of the cells with at least `occupied` percent. Throws std::invalid_argument naming the
/// field that cannot be.
[[nodiscard]] std::vector<navigation::Point2d> occupied_cells(
    const nav_msgs::msg::OccupancyGrid& message, int occupied);

[[nodiscard]] nav_msgs::msg::Path path_message(const navigation::Path& path);

[[nodiscard]] pipescout_msgs::msg::NavigatorState state_message(
    const navigation::MoveStatus& status);

/// Nothing before the first scan.
[[nodiscard]] std::optional<nav_msgs::msg::OccupancyGrid> costmap_message(
    const navigation::LocalCostmap& costmap);

[[nodiscard]] pipescout_msgs::msg::PipeCoverage coverage_message(
    std::int64_t row, const std::vector<navigation::CoverageMap::Cell>& cells, double cell);

/// Why it stands or is slow, in one line; empty: it is not.
[[nodiscard]] std::string reason_of(const navigation::MoveStatus& status);

}  // namespace pipescout
