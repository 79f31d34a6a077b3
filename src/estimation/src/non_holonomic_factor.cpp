// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/non_holonomic_factor.hpp"

#include "direction_of_travel.hpp"
#include "measurement_check.hpp"

namespace pipescout::estimation {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::skew;

InputFault check(const NonHolonomicMeasurement& m) noexcept {
  return verdict(finite({m.time, m.lateral_deviation, m.vertical_deviation}) &&
                     m.sensor.allFinite() && m.angular_rate.allFinite(),
                 is_deviation(m.lateral_deviation) && is_deviation(m.vertical_deviation));
}

void add_values(const NonHolonomicMeasurement& /*m*/, Fingerprint& /*fingerprint*/) {}

NonHolonomicFactor::NonHolonomicFactor(const NonHolonomicMeasurement& measurement)
    : MeasuredFactor(measurement) {
  whitening_ << 1 / measurement.lateral_deviation, 0, 0, 1 / measurement.vertical_deviation;
}

NonHolonomicFactor::Residual NonHolonomicFactor::evaluate(const NavState& x,
                                                          const GlobalStates& globals,
                                                          Derivatives* derivatives) const {
  const DirectionOfTravel travel(globals);
  const Vector3d origin = x.R_map_body.inverse() * x.velocity;
  const Vector3d unscaled = measurement_.angular_rate - x.gyro_bias;
  const Matrix3d& scale = globals.imu_scale.gyro;
  const Vector3d in_body = origin + (scale * unscaled).cross(measurement_.sensor);
  if (derivatives != nullptr) {
    const auto across = [&](const Matrix3d& m) { return (whitening_ * m.bottomRows<2>()).eval(); };
    derivatives->from.middleCols<3>(kRotation) = across(travel.R_travel_body * skew(origin));
    derivatives->from.middleCols<3>(kVelocity) =
        across(travel.R_travel_body * x.R_map_body.matrix().transpose());
    derivatives->from.middleCols<3>(kGyroBias) =
        across(travel.R_travel_body * skew(measurement_.sensor) * scale);
    derivatives->globals.col(kMountYaw) = whitening_ * (travel.by_yaw * in_body).tail<2>();
    derivatives->globals.col(kMountPitch) = whitening_ * (travel.by_pitch * in_body).tail<2>();
    const Eigen::Matrix<double, 2, 3> by_rate =
        across(-travel.R_travel_body * skew(measurement_.sensor));
    for (int row = 0; row < 3; ++row) {
      derivatives->globals.middleCols<3>(kImuScale + 3 * row) =
          by_rate.col(row) * unscaled.transpose();
    }
  }
  return whitening_ * (travel.R_travel_body * in_body).tail<2>();
}

}  // namespace pipescout::estimation
