// SPDX-License-Identifier: Apache-2.0
#include "navigator_messages.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout {
namespace {

using navigation::DriveReason;
using navigation::InspectionReason;
using navigation::MoveState;
using navigation::MoveStatus;
using navigation::NavigationFailure;
using navigation::Pose2d;

double yaw_of(const Eigen::Matrix3d& R) {
  return std::atan2(R(1, 0), R(0, 0));
}

/// Of the path in the message: dense enough for a picture, and no more.
constexpr double kPathStep = 0.2;  // m

}  // namespace

double seconds(Time time) {
  return to_seconds(time.time_since_epoch());
}

Pose2d plane_pose(const geometry_msgs::msg::Pose& message) {
  const geometry::SE3 pose = from_message(message);
  return {pose.translation().x(), pose.translation().y(), yaw_of(pose.rotation().matrix())};
}

geometry_msgs::msg::Pose pose_message(const Pose2d& pose) {
  geometry_msgs::msg::Pose message;
  message.position.x = pose.x;
  message.position.y = pose.y;
  message.orientation.w = std::cos(pose.heading / 2);
  message.orientation.z = std::sin(pose.heading / 2);
  return message;
}

navigation::Localisation localisation(const nav_msgs::msg::Odometry& message) {
  const auto covariance = covariance_from_message(message.pose.covariance);
  // The larger eigenvalue of the position in the plane.
  const double mean = (covariance(0, 0) + covariance(1, 1)) / 2;
  const double half = (covariance(0, 0) - covariance(1, 1)) / 2;
  const double variance = mean + std::hypot(half, covariance(0, 1));
  return {.time = seconds(from_message(message.header.stamp)),
          .pose = plane_pose(message.pose.pose),
          .speed = message.twist.twist.linear.x,
          .yaw_rate = message.twist.twist.angular.z,
          .sigma = std::sqrt(variance),
          .heading_sigma = std::sqrt(covariance(5, 5))};
}

std::vector<navigation::Point2d> occupied_cells(const nav_msgs::msg::OccupancyGrid& message,
                                                int occupied) {
  const auto& info = message.info;
  const auto width = static_cast<std::size_t>(info.width);
  const auto height = static_cast<std::size_t>(info.height);
  if (!(info.resolution > 0) || !std::isfinite(info.resolution)) {
    throw std::invalid_argument("info.resolution");
  }
  if (message.data.size() != width * height) {
    throw std::invalid_argument("data.size");
  }
  const Pose2d origin = plane_pose(info.origin);
  const auto resolution = static_cast<double>(info.resolution);
  std::vector<navigation::Point2d> cells;
  for (std::size_t i = 0; i < message.data.size(); ++i) {
    if (message.data[i] >= occupied) {
      cells.push_back(
          navigation::transform(origin, {(static_cast<double>(i % width) + 0.5) * resolution,
                                         (static_cast<double>(i / width) + 0.5) * resolution}));
    }
  }
  return cells;
}

nav_msgs::msg::Path path_message(const navigation::Path& path) {
  nav_msgs::msg::Path message;
  double last = -kPathStep;
  for (const navigation::PathPose& each : path.poses()) {
    const bool end = &each == &path.poses().back();
    if (each.arc_length - last < kPathStep && !end) {
      continue;
    }
    last = each.arc_length;
    geometry_msgs::msg::PoseStamped pose;
    pose.pose = pose_message(each.pose);
    message.poses.push_back(std::move(pose));
  }
  return message;
}

std::optional<nav_msgs::msg::OccupancyGrid> costmap_message(
    const navigation::LocalCostmap& costmap) {
  const auto origin = costmap.origin();
  if (!origin) {
    return std::nullopt;
  }
  constexpr std::int8_t kUnknown = -1;
  constexpr std::int8_t kOccupied = 100;
  const int size = costmap.parameters().size;
  nav_msgs::msg::OccupancyGrid message;
  message.info.resolution = static_cast<float>(costmap.parameters().resolution);
  message.info.width = static_cast<std::uint32_t>(size);
  message.info.height = static_cast<std::uint32_t>(size);
  message.info.origin = pose_message({origin->x, origin->y, 0});
  message.data.reserve(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
  using State = navigation::LocalCostmap::State;
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      const State state = costmap.at(column, row);
      message.data.push_back(state == State::kUnknown
                                 ? kUnknown
                                 : (state == State::kOccupied ? kOccupied : std::int8_t{0}));
    }
  }
  return message;
}

pipescout_msgs::msg::PipeCoverage coverage_message(
    std::int64_t row, const std::vector<navigation::CoverageMap::Cell>& cells, double cell) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  pipescout_msgs::msg::PipeCoverage message;
  message.row = row;
  message.cell = cell;
  for (const auto& each : cells) {
    const bool seen = each.time > 0;
    message.sharp.push_back(each.sharp);
    message.blur.push_back(seen ? static_cast<float>(each.blur) : kNone);
    message.temperature.push_back(seen ? static_cast<float>(each.temperature) : kNone);
  }
  return message;
}

std::string reason_of(const MoveStatus& status) {
  if (status.state == MoveState::kFailed) {
    return to_string(status.failure) + (status.text.empty() ? "" : ": " + status.text);
  }
  if (status.waits_for != DriveReason::kNone) {
    return to_string(status.waits_for);
  }
  if (status.state == MoveState::kDriving && status.command.reason != DriveReason::kNone) {
    return to_string(status.command.reason);
  }
  return "";
}

pipescout_msgs::msg::NavigatorState state_message(const MoveStatus& status) {
  const navigation::DriveCommand& command = status.command;
  pipescout_msgs::msg::NavigatorState message;
  message.state = to_string(status.state);
  message.drive = to_string(command.state);
  message.reason = reason_of(status);
  message.inspection =
      status.inspection == InspectionReason::kNone ? "" : to_string(status.inspection);
  message.failure = status.failure == NavigationFailure::kNone ? "" : to_string(status.failure);
  message.speed = command.speed;
  message.curvature = command.curvature;
  message.travelled = command.travelled;
  message.remaining = status.remaining;
  message.lateral_error = command.lateral_error;
  message.heading_error = command.heading_error;
  message.offset = command.offset;
  message.free_distance = command.free_distance;
  message.replans = static_cast<std::uint32_t>(status.replans);
  message.passed = static_cast<std::uint32_t>(status.passed);
  return message;
}

}  // namespace pipescout
