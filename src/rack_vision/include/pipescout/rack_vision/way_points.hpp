// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

/// A path through way-points for the visual servo (Lippiello and Cacace, sections IV and V): "a
/// motion trajectory with continuous acceleration [...] considering a maximum cruise velocity".
///
/// Straight from one way-point to the next, from rest to rest; the yaw takes the shorter direction
/// over the same time. Speed rises and falls along a cubic (3 t^2 - 2 t^3), with a cruise between
/// where the leg is long enough: velocity and acceleration are continuous everywhere, the jerk is
/// bounded.
namespace pipescout::rack_vision {

/// Angle in (-pi, pi] that differs from `angle`, rad, finite, by a multiple of 2 pi.
[[nodiscard]] double wrap_angle(double angle) noexcept;

/// Reference pose of the vehicle (frame `base_link`: x forward, y left, z up). Roll and pitch are
/// not prescribed: a rotorcraft needs them to hold its position.
struct WayPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< of the vehicle, rack frame, m
  double yaw = 0;   ///< rad: direction of the vehicle's x axis, from rack x towards rack y
  double hold = 2;  ///< s, [0, 3600]: shortest stay
};

struct WayPointPathParameters {
  /// m/s, (0, 20]. Below the 0.5 m/s at which the servo saturates (`VisualServoParameters`), so
  /// that it can catch up while it cruises.
  double largest_speed = 0.4;
  double largest_acceleration = 0.5;      ///< m/s^2, (0, 20]
  double largest_yaw_rate = 0.16;         ///< rad/s, (0, 6]: below the servo's 0.2, as above
  double largest_yaw_acceleration = 0.3;  ///< rad/s^2, (0, 20]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Reference of the path at one time; rack frame, SI units.
struct PathPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  double yaw = 0;  ///< rad, (-pi, pi]
  double yaw_rate = 0;
  double yaw_acceleration = 0;
  std::size_t way_point = 0;  ///< index of the current one, where it stays or to which it flies
  bool holding = true;        ///< stays at the way-point
};

/// Immutable; any number of threads may call concurrently. Nothing is allocated after construction.
class WayPointPath {
 public:
  static constexpr std::size_t kMostWayPoints = 1000;

  /// Throws std::invalid_argument as WayPointPathParameters::validate, and when there are not 1 to
  /// kMostWayPoints way-points, a coordinate is not finite or beyond 1e5 m, a yaw not finite or a
  /// hold outside its range.
  WayPointPath(std::span<const WayPoint> way_points, const WayPointPathParameters& parameters);

  /// At a time, s from the start, which begins with the hold at the first way-point. Clamped to
  /// start and end; NaN is treated as 0.
  [[nodiscard]] PathPoint at(double time) const noexcept;
  /// s: until the hold at the last way-point is over.
  [[nodiscard]] double duration() const noexcept { return stays_.back().departure; }
  /// s: arrival at and departure from way-point `i`; `i` is not checked.
  [[nodiscard]] double arrival(std::size_t i) const noexcept { return stays_[i].arrival; }
  [[nodiscard]] double departure(std::size_t i) const noexcept { return stays_[i].departure; }
  [[nodiscard]] const std::vector<WayPoint>& way_points() const noexcept { return way_points_; }

 private:
  struct Stay {
    double arrival = 0;
    double departure = 0;
  };
  /// Leg from a way-point to the next one; its progress goes from 0 to 1.
  struct Leg {
    Eigen::Vector3d displacement = Eigen::Vector3d::Zero();
    double turn = 0;
    double rate = 0;    ///< of the progress while it cruises, 1/s
    double ramp = 0;    ///< s, of acceleration and of deceleration
    double cruise = 0;  ///< s, between the ramps
  };

  std::vector<WayPoint> way_points_;
  std::vector<Stay> stays_;
  std::vector<Leg> legs_;
};

/// When a way-point counts as reached. The defaults are those of an inspection by hand-held tools:
/// 3 cm and 1 degree.
struct ReachedTolerance {
  double position = 0.03;             ///< m, (0, 10]
  double yaw = 0.017453292519943295;  ///< rad, (0, pi]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Whether a vehicle at `position` (rack frame, m) with `yaw` (rad) has reached the way-point.
/// False for NaN.
[[nodiscard]] bool is_reached(const WayPoint& way_point, const Eigen::Vector3d& position,
                              double yaw, const ReachedTolerance& tolerance) noexcept;

}  // namespace pipescout::rack_vision
