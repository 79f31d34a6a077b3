// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>

#include "pipescout/estimation_study/vehicle_run.hpp"

namespace pipescout::estimation_study::internal {

/// What a position that has come is off from its prediction, against what both are said to be off.
class Innovations {
 public:
  Innovations(const geometry::SO3& R_body_imu, double gravity, const estimation::ImuNoise& noise)
      : R_body_imu_(R_body_imu), gravity_(gravity), noise_(noise) {}

  void add(const estimation::ImuReading& reading);
  /// Of a GPS position or weld that the smoother has not been given yet: the newest keyframe at or
  /// before it is carried to its time by the IMU. Nothing of other readings, or when it is older
  /// than the keyframes or newer than the IMU.
  [[nodiscard]] std::optional<double> nis(const estimation::FixedLagSmoother& smoother,
                                          const Reading& reading) const;

 private:
  struct Prediction {
    estimation::NavState state;
    estimation::StateMatrix covariance;
  };
  [[nodiscard]] std::optional<Prediction> predict(const estimation::FixedLagSmoother& smoother,
                                                  double time) const;

  geometry::SO3 R_body_imu_;
  double gravity_;
  estimation::ImuNoise noise_;
  std::deque<estimation::ImuReading> readings_;
};

}  // namespace pipescout::estimation_study::internal
