// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <geometry_msgs/msg/transform_stamped.hpp>
#include <string>
#include <vector>

#include "pipescout/runtime/transform_buffer.hpp"

/// Transforms as `pipescout tf` prints them.
namespace pipescout::host {

/// As `tf2_echo` of ROS 2: time, translation, rotation as quaternion, roll, pitch and yaw, and
/// matrix. Ends with a line end.
[[nodiscard]] std::string to_echo(const geometry_msgs::msg::TransformStamped& transform);

/// The trees, each frame below its parent and indented under it, sorted by name. `told_by` names
/// who sent a frame.
[[nodiscard]] std::string to_tree(const std::vector<TransformFrame>& frames,
                                  const std::function<std::string(const Gid&)>& told_by);

/// Delays of one frame or of one publisher since the monitor began: from the stamps of transforms
/// to their arrival.
class DelayStatistics {
 public:
  /// `delay`: s; `arrival`: of the message.
  void add(double delay, SteadyTime arrival);

  [[nodiscard]] double average() const;
  [[nodiscard]] double most() const { return most_; }
  /// Hz; 0 before the second.
  [[nodiscard]] double rate() const;

 private:
  std::uint64_t count_ = 0;
  double sum_ = 0;
  double most_ = 0;
  SteadyTime first_{};
  SteadyTime last_{};
};

}  // namespace pipescout::host
