// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace pipescout::estimation {

/// A base with driven wheels on its left and right side.
struct WheelDriveParameters {
  std::vector<std::string> left;   ///< names of the joints of the wheels, one or more
  std::vector<std::string> right;  ///< the same; no name stands twice
  double wheel_radius = 0;         ///< m, above 0
  double track = 0;                ///< m between the wheels of the two sides, above 0
  /// s: the angles of wheels that come in several messages lie at most so far apart.
  double largest_spread = 0.1;
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Motion of the base between its wheels.
struct WheelMotion {
  double time = 0;      ///< s
  double speed = 0;     ///< m/s, forwards positive
  double yaw_rate = 0;  ///< rad/s, to the left positive
};

/// Joint states of wheels to the motion of the base, by the kinematics of a differential drive
/// (Siegwart and Nourbakhsh, Introduction to Autonomous Mobile Robots, 2nd edition, equation 3.2),
/// with the mean of the wheels of a side. Joints that are no wheels are passed over; wheels may
/// come in several messages.
class WheelDrive {
 public:
  explicit WheelDrive(WheelDriveParameters parameters);

  /// The joints of one message: angles, rad, and rates, rad/s, each empty or one for each name, as
  /// sensor_msgs/JointState has them. Rates are used where there are any; else the change of the
  /// angle since the message before, and the motion then holds at the middle between both. Once all
  /// wheels are known: the motion, at the mean of their times. Throws std::invalid_argument naming
  /// a wheel and the field for values that are missing or not finite, a length that does not fit,
  /// or a time that is not after the last one of that wheel; the message then changes nothing.
  [[nodiscard]] std::optional<WheelMotion> add(double time, std::span<const std::string> names,
                                               std::span<const double> positions,
                                               std::span<const double> velocities);

 private:
  struct Wheel {
    std::optional<double> time{};       // s, of its last message
    std::optional<double> angle{};      // rad, then
    std::optional<double> rate_time{};  // s, of a rate that no motion has used yet
    double rate = 0;                    // rad/s
  };

  /// Throws as `add`, which then has changed nothing.
  template <class HasRate>
  void check_wheels(double time, std::span<const std::string> names,
                    std::span<const double> positions, HasRate&& has_rate) const;
  /// In `wheels_`; nothing for a joint that is no wheel.
  [[nodiscard]] std::optional<std::size_t> place_of(const std::string& joint) const;
  /// Once all wheels have a rate.
  [[nodiscard]] std::optional<WheelMotion> motion();

  WheelDriveParameters parameters_;
  std::vector<Wheel> wheels_;  // left, then right
};

}  // namespace pipescout::estimation
