// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/odometer_factor.hpp"

#include <cmath>

#include "direction_of_travel.hpp"
#include "measurement_check.hpp"

namespace pipescout::estimation {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::skew;

namespace {

/// sin(a) / a and (d/da of it) / a, a >= 0.
struct Sinc {
  double value;
  double slope;
};

Sinc sinc(double a) {
  constexpr double kSmall = 1e-2;  // the next terms are below 1e-12 there
  if (a < kSmall) {
    const double q = a * a;
    return {1 - q / 6 * (1 - q / 20), -1.0 / 3 + q / 30 * (1 - q / 28)};
  }
  const double value = std::sin(a) / a;
  return {value, (std::cos(a) - value) / (a * a)};
}

}  // namespace

InputFault check(const OdometerMeasurement& m) noexcept {
  const InputFault fault = verdict(
      finite({m.from_time, m.to_time, m.distance, m.standard_deviation, m.across_deviation}) &&
          m.sensor.allFinite(),
      is_deviation(m.standard_deviation) && is_deviation(m.across_deviation));
  return fault == InputFault::kNone && m.to_time <= m.from_time ? InputFault::kBadInterval : fault;
}

void add_values(const OdometerMeasurement& m, Fingerprint& fingerprint) {
  fingerprint.add(m.distance);
}

OdometerFactor::OdometerFactor(const OdometerMeasurement& measurement)
    : MeasuredFactor(measurement) {
  const double across = 1 / measurement.across_deviation;
  whitening_ = Vector3d(1 / measurement.standard_deviation, across, across).asDiagonal();
}

OdometerFactor::Residual OdometerFactor::evaluate(const NavState& from, const NavState& to,
                                                  const GlobalStates& globals,
                                                  Derivatives* derivatives) const {
  const DirectionOfTravel travel(globals);
  const Matrix3d to_from = from.R_map_body.matrix().transpose();
  const Matrix3d to_to = to.R_map_body.matrix().transpose();
  const Vector3d& sensor = measurement_.sensor;
  const Vector3d at_from = from.R_map_body * sensor;
  const Vector3d at_to = to.R_map_body * sensor;
  const Vector3d moved = to.position - from.position;
  // How each end sees the way from its own origin, and to it.
  const Vector3d from_origin = to_from * (moved + at_to);
  const Vector3d to_origin = to_to * (moved - at_from);
  const Vector3d in_body = 0.5 * (from_origin + to_origin);
  const Vector3d turn = (from.R_map_body.inverse() * to.R_map_body).log();
  const Sinc bend = sinc(turn.norm());
  const Vector3d travelled = travel.R_travel_body * in_body;
  const double scale = globals.odometer_scale;
  Vector3d r = travelled;
  r.x() = travelled.x() / scale - measurement_.distance * bend.value;
  if (derivatives != nullptr) {
    const Matrix3d scaled = whitening_ * Vector3d(1 / scale, 1, 1).asDiagonal();
    const Matrix3d whitened = scaled * travel.R_travel_body;
    const Matrix3d by_position = 0.5 * whitened * (to_from + to_to);
    derivatives->from.middleCols<3>(kPosition) = -by_position;
    derivatives->to.middleCols<3>(kPosition) = by_position;
    derivatives->from.middleCols<3>(kRotation) =
        0.5 * whitened * (skew(from_origin) + to_to * from.R_map_body.matrix() * skew(sensor));
    derivatives->to.middleCols<3>(kRotation) =
        0.5 * whitened * (skew(to_origin) - to_from * to.R_map_body.matrix() * skew(sensor));
    // The angle's gradient is the axis of the turn, at both ends.
    const Vector3d by_turn = whitening_(0, 0) * measurement_.distance * bend.slope * turn;
    derivatives->from.block<1, 3>(0, kRotation) += by_turn.transpose();
    derivatives->to.block<1, 3>(0, kRotation) -= by_turn.transpose();
    derivatives->globals(0, kOdometerScale) = -whitening_(0, 0) * travelled.x() / (scale * scale);
    derivatives->globals.col(kMountYaw) = scaled * travel.by_yaw * in_body;
    derivatives->globals.col(kMountPitch) = scaled * travel.by_pitch * in_body;
  }
  return whitening_ * r;
}

}  // namespace pipescout::estimation
