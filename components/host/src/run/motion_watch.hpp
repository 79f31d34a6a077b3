// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <geometry_msgs/msg/twist.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <memory>
#include <mutex>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pipescout/runtime/node.hpp"

namespace pipescout::host {

/// Whether the odometry says that the robot stands: its speeds are zero within three standard
/// deviations (99.7 %), and these are below the speeds at which Nav2 takes a robot for stopped, so
/// that one that does not know its speed is not taken for standing. Without covariances: zero.
[[nodiscard]] bool says_standing(const nav_msgs::msg::Odometry& odometry);

/// Whether a robot moves, by what is commanded on `cmd_vel` and `cmd_vel_stamped` and by its
/// `odometry/filtered`, as far as these are published. Thread-safe.
class MotionWatch {
 public:
  /// `namespaces`: of the robot's nodes. `node` must outlive this object.
  MotionWatch(Node& node, const std::set<std::string>& namespaces);

  /// True when it is known that the robot stands: for the last second nothing but zero was
  /// commanded, and odometry that is published says so.
  [[nodiscard]] bool stands(SteadyTime now) const;

 private:
  struct Odometry {
    std::string topic;
    std::optional<SteadyTime> heard_at;
    bool stands = false;
    Subscription<nav_msgs::msg::Odometry> subscription;
  };

  void on_command(const geometry_msgs::msg::Twist& command);

  Node& node_;
  const std::shared_ptr<CallbackGroup> group_;
  mutable std::mutex mutex_;
  SteadyTime may_move_until_;
  std::vector<std::unique_ptr<Odometry>> odometry_;
  std::vector<Subscription<geometry_msgs::msg::Twist>> commands_;
  std::vector<Subscription<geometry_msgs::msg::TwistStamped>> stamped_commands_;
};

}  // namespace pipescout::host
