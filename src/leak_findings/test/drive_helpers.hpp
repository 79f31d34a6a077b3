// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/leak_findings/leak_findings.hpp"

namespace pipescout::leak_findings::test {

/// What is warm on the pipe, or seems to be.
struct Spot {
  double place = 0;  ///< m, along the pipe, of its middle
  double length = 0.3;
  double delta = 90;  ///< K
  double follow = 0;  ///< it moves so much per metre that the camera goes
};

/// A robot that drives along x past a pipe that is parallel to its way, 10 m to the left and 2 m
/// up, and what a detector tells of it: made by projection, without pictures.
class Drive {
 public:
  static constexpr double kRange = 10.0;
  static constexpr double kHeight = 2.0;
  static constexpr double kSpeed = 5.5;    // m/s
  static constexpr double kPeriod = 0.04;  // s
  static constexpr double kDiameter = 0.12;

  explicit Drive(std::uint64_t seed = 1) : engine_(seed) {}

  std::vector<Spot> spots{};
  std::vector<Eigen::Vector2d> posts{};  ///< from, to along the pipe: hidden there
  double width_seen = 1.03;              ///< over the true one; NaN: the pipe's edges are not seen
  bool cut_along = false;                ///< by the border of the picture
  double pixel_noise = 0.3;
  double delta_noise = 1.0;
  double delta_deviation = std::numeric_limits<double>::quiet_NaN();  ///< that detections tell
  /// What the poses that are told are off: m and rad in the axes of the map.
  Eigen::Vector3d position_error = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_error = Eigen::Vector3d::Zero();
  double position_deviation = 0.1;  ///< as the covariance of the poses tells
  double rotation_deviation = 0.005;

  [[nodiscard]] static const geometry::Camera& camera();
  [[nodiscard]] static geometry::SE3 T_base_camera();
  [[nodiscard]] static LeakFindingsParameters parameters();
  /// Where a place of the pipe is.
  [[nodiscard]] static Eigen::Vector3d on_pipe(double place) { return {place, kRange, kHeight}; }

  /// The robot at `x`.
  [[nodiscard]] Frame frame(double time, double x);
  [[nodiscard]] thermal::Detections look(double x);

 private:
  [[nodiscard]] double normal(double deviation);
  std::mt19937_64 engine_;
  std::uint64_t number_ = 0;
};

/// All events of a drive from one place to another.
struct Told {
  Event event;
  double time = 0;
};
std::vector<Told> drive(LeakFindings& findings, Drive& drive, double from, double to,
                        double start_time, double speed = Drive::kSpeed);
[[nodiscard]] std::size_t count(const std::vector<Told>& told, EventKind kind);

}  // namespace pipescout::leak_findings::test
