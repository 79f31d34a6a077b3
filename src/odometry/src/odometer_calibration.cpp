// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/odometer_calibration.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "pipescout/validation/check.hpp"

namespace pipescout::odometry {
namespace {

using validation::refuse;
using validation::require;

using Matrix2 = Eigen::Matrix<double, 2, 2, Eigen::DontAlign>;
using Vector2 = Eigen::Matrix<double, 2, 1, Eigen::DontAlign>;

Matrix2 start_covariance(const OdometerCalibrationParameters& parameters) {
  const double scale = parameters.initial_scale_standard_deviation;
  const double offset = parameters.initial_offset_standard_deviation;
  return Matrix2{{scale * scale, 0.0}, {0.0, offset * offset}};
}

bool usable(const WeldSpacing& spacing) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  const auto sigma = [](double value) { return std::isfinite(value) && value >= 0.0; };
  return positive(spacing.measured) && positive(spacing.length) &&
         sigma(spacing.measured_standard_deviation) && sigma(spacing.length_standard_deviation) &&
         spacing.measured_standard_deviation + spacing.length_standard_deviation > 0.0;
}

bool in_range(double scale) {
  return scale >= 0.5 && scale <= 2.0;
}

}  // namespace

void OdometerCalibrationParameters::validate() const {
  require("initial_scale", initial_scale, in_range(initial_scale), "[0.5, 2]");
  require("initial_scale_standard_deviation", initial_scale_standard_deviation,
          initial_scale_standard_deviation > 0.0 && initial_scale_standard_deviation <= 0.5,
          "(0, 0.5]");
  require("initial_offset", initial_offset, true, "(-inf, inf)");
  require("initial_offset_standard_deviation", initial_offset_standard_deviation,
          initial_offset_standard_deviation >= 0.0, "[0, inf)");
  require("scale_drift", scale_drift, scale_drift >= 0.0 && scale_drift <= 1e-4, "[0, 1e-4]");
  require("gate", gate, gate >= 1.0 && gate <= 10.0, "[1, 10]");
  if (change_after < 2) {
    refuse("change_after: ", change_after, " is outside [2, inf)");
  }
}

OdometerCalibration::OdometerCalibration(OdometerCalibrationParameters parameters,
                                         std::size_t odometers)
    : parameters_(parameters), odometers_(odometers) {
  parameters_.validate();
  if (odometers < kMinOdometers || odometers > kMaxOdometers) {
    refuse("odometers: ", odometers, " is outside [", kMinOdometers, ", ", kMaxOdometers, "]");
  }
  for (Track& track : tracks_) {
    track.correction = {.scale = parameters_.initial_scale,
                        .offset = parameters_.initial_offset,
                        .covariance = start_covariance(parameters_)};
  }
}

CalibrationOutcome OdometerCalibration::observe(std::size_t odometer, const WeldSpacing& spacing) {
  static_cast<void>(track(odometer));
  Track& track = tracks_[odometer];
  if (!usable(spacing)) {
    ++track.counts.bad_values;
    return CalibrationOutcome::kBadValue;
  }
  OdometerCorrection& now = track.correction;
  Matrix2 covariance = now.covariance;
  // No more than at the start: a scale that is not observed does not become arbitrary.
  covariance(0, 0) = std::max(
      covariance(0, 0), std::min(covariance(0, 0) + parameters_.scale_drift * spacing.measured,
                                 start_covariance(parameters_)(0, 0)));
  const Vector2 direction(spacing.measured, 1.0);
  const double residual = spacing.length - now.scale * spacing.measured - now.offset;
  const double measured_sigma = now.scale * spacing.measured_standard_deviation;
  double noise = measured_sigma * measured_sigma +
                 spacing.length_standard_deviation * spacing.length_standard_deviation;
  const double expected = direction.dot(covariance * direction) + noise;
  const double excess = residual * residual / (parameters_.gate * parameters_.gate * expected);
  const bool far_off = !(excess <= 1.0);
  if (far_off) {
    track.far_off_in_a_row += 1;
    if (track.far_off_in_a_row >= parameters_.change_after) {
      track.far_off_in_a_row = 0;
      ++track.counts.changes;
      now.covariance = start_covariance(parameters_);
      return CalibrationOutcome::kChanged;
    }
    // Not the noise alone: while scale and offset are uncertain, they make up most of `expected`.
    noise += expected * (excess - 1.0);
  } else {
    track.far_off_in_a_row = 0;
  }
  const Vector2 gain = covariance * direction / (direction.dot(covariance * direction) + noise);
  const double scale = now.scale + gain(0) * residual;
  const double offset = now.offset + gain(1) * residual;
  if (!in_range(scale) || !std::isfinite(offset)) {
    ++track.counts.bad_values;
    return CalibrationOutcome::kBadValue;
  }
  now.scale = scale;
  now.offset = offset;
  // Joseph's form stays symmetric and positive semi-definite.
  const Matrix2 kept = Matrix2::Identity() - gain * direction.transpose();
  now.covariance = kept * covariance * kept.transpose() + noise * gain * gain.transpose();
  ++(far_off ? track.counts.far_off : track.counts.used);
  return far_off ? CalibrationOutcome::kFarOff : CalibrationOutcome::kUsed;
}

const OdometerCorrection& OdometerCalibration::correction(std::size_t odometer) const {
  return track(odometer).correction;
}

const OdometerCalibration::Counts& OdometerCalibration::counts(std::size_t odometer) const {
  return track(odometer).counts;
}

const OdometerCalibration::Track& OdometerCalibration::track(std::size_t odometer) const {
  if (odometer >= odometers_) {
    throw std::out_of_range("odometer: " + std::to_string(odometer) + " is outside [0, " +
                            std::to_string(odometers_) + ")");
  }
  return tracks_[odometer];
}

const char* to_string(CalibrationOutcome outcome) noexcept {
  switch (outcome) {
    case CalibrationOutcome::kUsed:
      return "used";
    case CalibrationOutcome::kFarOff:
      return "far off";
    case CalibrationOutcome::kChanged:
      return "changed";
    case CalibrationOutcome::kBadValue:
      return "bad value";
  }
  return "unknown";
}

}  // namespace pipescout::odometry
