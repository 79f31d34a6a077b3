// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "pipescout/simulation/body_motion.hpp"
#include "pipescout/simulation/jointed_pipe.hpp"

/// A pipeline's centre line in space, smooth enough for a simulated inertial sensor. Metres and
/// radians; map frame, z up; chainage is the length along the line from its beginning.
namespace pipescout::simulation {

/// A segment of constant rates. A straight has none, a bend one of them.
struct RoutePiece {
  double length = 0;        ///< m
  double heading_rate = 0;  ///< rad/m, to the left
  double pitch_rate = 0;    ///< rad/m, upwards

  [[nodiscard]] static RoutePiece straight(double length) noexcept { return {length, 0, 0}; }
  /// Level bend of a radius, m, by an angle, to the left when positive.
  [[nodiscard]] static RoutePiece bend(double radius, double angle) noexcept;
  /// Upright bend, upwards when positive.
  [[nodiscard]] static RoutePiece slope_bend(double radius, double angle) noexcept;
};

/// The segments of a pipe of welded joints, one per joint, with the same chainages of the welds.
[[nodiscard]] std::vector<RoutePiece> route_pieces(const JointedPipe& pipe);

class PipeRoute {
 public:
  /// From one piece to the next the rates change evenly over `ease`, m, half of it in each: as for
  /// a vehicle of about this length. Angles of the segments are kept. Throws std::invalid_argument
  /// when there are no pieces, one is shorter than `ease` or not finite, `ease` is outside [0.001,
  /// 100], or start or heading is not finite.
  PipeRoute(std::span<const RoutePiece> pieces, double ease,
            const Eigen::Vector3d& start = Eigen::Vector3d::Zero(), double heading = 0);

  [[nodiscard]] double length() const noexcept { return knots_.back().chainage; }
  /// Straight on beyond the ends. Exact to 1e-9 m.
  [[nodiscard]] Eigen::Vector3d position(double chainage) const noexcept;

  /// Of a vehicle on the line at a chainage, x axis along it, y axis level, with this speed and
  /// acceleration along it (m/s, m/s^2; negative: backwards). `time` of the result is 0.
  [[nodiscard]] BodyMotion motion(double chainage, double speed, double acceleration) const;

  /// Points on the line from the beginning to the end, at most `spacing` m apart. Throws
  /// std::invalid_argument unless it is in [0.001, 1e6].
  [[nodiscard]] std::vector<Eigen::Vector3d> polyline(double spacing) const;

 private:
  /// Rates change evenly from a knot to the next.
  struct Knot {
    double chainage = 0;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::Vector2d angles = Eigen::Vector2d::Zero();  ///< heading, pitch
    Eigen::Vector2d rates = Eigen::Vector2d::Zero();   ///< rad/m
    Eigen::Vector2d change = Eigen::Vector2d::Zero();  ///< rad/m^2, of the rates, to the next knot
  };
  [[nodiscard]] const Knot& knot_at(double chainage) const noexcept;
  [[nodiscard]] static Eigen::Vector3d advance(const Knot& knot, double length) noexcept;
  void append(double chainage, const Eigen::Vector2d& rates);

  std::vector<Knot> knots_;
};

}  // namespace pipescout::simulation
