// SPDX-License-Identifier: Apache-2.0
// What measurements may hold.
#include <cmath>
#include <initializer_list>

#include "pipescout/estimation/factors.hpp"
#include "square_root_information.hpp"

namespace pipescout::estimation {
namespace {

bool finite(std::initializer_list<double> values) {
  for (const double value : values) {
    if (!std::isfinite(value)) {
      return false;
    }
  }
  return true;
}

bool finite(const geometry::SE3& t) {
  return t.translation().allFinite() && t.rotation().quaternion().coeffs().allFinite();
}

bool is_unit(const Eigen::Vector3d& direction) {
  constexpr double kUnit = 1e-6;
  return std::abs(direction.norm() - 1) <= kUnit;
}

InputFault verdict(bool all_finite, bool good_covariance) {
  if (!all_finite) {
    return InputFault::kNotFinite;
  }
  return good_covariance ? InputFault::kNone : InputFault::kBadCovariance;
}

}  // namespace

InputFault check(const GpsMeasurement& m) noexcept {
  return verdict(finite({m.time}) && m.position.allFinite() && m.covariance.allFinite() &&
                     m.angular_rate.allFinite(),
                 is_covariance(m.covariance));
}

InputFault check(const HeadingMeasurement& m) noexcept {
  return verdict(finite({m.time, m.heading, m.standard_deviation}),
                 is_deviation(m.standard_deviation));
}

InputFault check(const VisualPoseMeasurement& m) noexcept {
  return verdict(finite({m.time}) && finite(m.T_rack_body) && m.covariance.allFinite(),
                 is_covariance(m.covariance));
}

InputFault check(const WeldMeasurement& m) noexcept {
  const InputFault fault =
      verdict(finite({m.time, m.along_deviation, m.across_deviation}) && m.position.allFinite() &&
                  m.sensor.allFinite() && m.direction.allFinite(),
              is_deviation(m.along_deviation) && is_deviation(m.across_deviation));
  return fault == InputFault::kNone && !is_unit(m.direction) ? InputFault::kBadDirection : fault;
}

InputFault check(const CentreLineMeasurement& m) noexcept {
  const InputFault fault = verdict(
      finite({m.time, m.standard_deviation}) && m.position.allFinite() && m.direction.allFinite(),
      is_deviation(m.standard_deviation));
  return fault == InputFault::kNone && !is_unit(m.direction) ? InputFault::kBadDirection : fault;
}

InputFault check(const NonHolonomicMeasurement& m) noexcept {
  return verdict(finite({m.time, m.lateral_deviation, m.vertical_deviation}) &&
                     m.sensor.allFinite() && m.angular_rate.allFinite(),
                 is_deviation(m.lateral_deviation) && is_deviation(m.vertical_deviation));
}

InputFault check(const ZeroVelocityMeasurement& m) noexcept {
  return verdict(finite({m.time, m.standard_deviation}), is_deviation(m.standard_deviation));
}

InputFault check(const ZeroAngularRateMeasurement& m) noexcept {
  return verdict(finite({m.time, m.standard_deviation}) && m.angular_rate.allFinite(),
                 is_deviation(m.standard_deviation));
}

InputFault check(const OdometerMeasurement& m) noexcept {
  const InputFault fault = verdict(
      finite({m.from_time, m.to_time, m.distance, m.standard_deviation, m.across_deviation}) &&
          m.sensor.allFinite(),
      is_deviation(m.standard_deviation) && is_deviation(m.across_deviation));
  return fault == InputFault::kNone && m.to_time <= m.from_time ? InputFault::kBadInterval : fault;
}

InputFault check(const RelativePoseMeasurement& m) noexcept {
  const InputFault fault =
      verdict(finite({m.from_time, m.to_time}) && finite(m.T_from_to) && m.covariance.allFinite(),
              is_covariance(m.covariance));
  return fault == InputFault::kNone && m.to_time <= m.from_time ? InputFault::kBadInterval : fault;
}

std::string_view to_string(FactorKind kind) noexcept {
  switch (kind) {
    case FactorKind::kImu:
      return "imu";
    case FactorKind::kPrior:
      return "prior";
    case FactorKind::kGps:
      return "gps";
    case FactorKind::kHeading:
      return "heading";
    case FactorKind::kVisualPose:
      return "visual_pose";
    case FactorKind::kWeld:
      return "weld";
    case FactorKind::kNonHolonomic:
      return "non_holonomic";
    case FactorKind::kZeroVelocity:
      return "zero_velocity";
    case FactorKind::kOdometer:
      return "odometer";
    case FactorKind::kRelativePose:
      return "relative_pose";
    case FactorKind::kZeroAngularRate:
      return "zero_angular_rate";
    case FactorKind::kCentreLine:
      return "centre_line";
  }
  return "unknown";
}

}  // namespace pipescout::estimation
