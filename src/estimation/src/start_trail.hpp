// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "odometer_intake.hpp"
#include "pipescout/estimation/imu_preintegration.hpp"

namespace pipescout::estimation {

/// Where the body was before its levelling ended: by gyro and odometer, backwards from that time.
/// A pose that is given for an earlier time is used through it. Nothing allocates after
/// construction.
class StartTrail {
 public:
  StartTrail();

  /// In order of time. After `settle` a new trail begins, and after a gap of the IMU.
  void add(const ImuSample& sample);
  void forget() noexcept;
  [[nodiscard]] bool empty() const noexcept { return steps_.empty(); }
  /// s, of what is not empty.
  [[nodiscard]] double begins() const noexcept { return steps_.front().time; }
  [[nodiscard]] double ends() const noexcept { return end_; }

  /// What is known of the motion at the end.
  struct Motion {
    Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();           // rad/s
    double gyro_bias_deviation = 0;                                // rad/s
    double stands_from = std::numeric_limits<double>::infinity();  // s: from then to the end
    std::optional<double> speed{};                                 // m/s, by the odometer
    double speed_deviation = 0;  // m/s, of it, or of the velocity without an odometer
    double odometer_scale = 1;
    Eigen::Vector3d travel = Eigen::Vector3d::UnitX();  // direction in the body
    Eigen::Vector3d sensor = Eigen::Vector3d::Zero();   // m, of the odometer in the body
  };
  /// With the body at `end` at the end, and z of its frame upwards.
  void settle(const geometry::SE3& end, const Motion& motion, const OdometerIntake& odometer);
  /// Moves all of it, which is settled, by a transform of its frame.
  void move(const geometry::SE3& by);

  struct Place {
    geometry::SE3 pose{};
    double position_deviation = 0;  // m, relative to the end
    double heading_deviation = 0;   // rad, the same
  };
  /// Nothing unless settled, and after the end. Before the beginning it is the place of the
  /// beginning, with deviations that grow with a motion that goes on.
  [[nodiscard]] std::optional<Place> at(double time) const;

 private:
  struct Step {
    double time = 0;      // s, its begin
    double duration = 0;  // s
    geometry::SO3 turn{};
    Place begin{};
  };

  /// m over a step, and its deviation.
  struct Way {
    double distance = 0;
    double variance = 0;   // m^2, independent from step to step
    double deviation = 0;  // m, the same at all steps
  };
  [[nodiscard]] static Way way_of(const Step& step, const Motion& motion,
                                  const OdometerIntake& odometer);

  std::vector<Step> steps_{};  // oldest first
  double end_ = 0;
  bool settled_ = false;
  Place last_{};  // of the end
  // Of what went before the beginning, if it moves then.
  double speed_before_ = 0;  // m/s
  double rate_before_ = 0;   // rad/s
};

}  // namespace pipescout::estimation
