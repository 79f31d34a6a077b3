// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/long_drive.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "pipescout/estimation/fixed_lag_smoother.hpp"

namespace pipescout::estimation_study {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using estimation::NavState;
using geometry::SO3;

// WGS 84.
constexpr double kSemiMajor = 6378137.0;
constexpr double kFlattening = 1 / 298.257223563;
constexpr double kEarthRate = 7.292115e-5;  // rad/s
constexpr double kEquatorGravity = 9.7803253359;
constexpr double kSomigliana = 1.931852652458e-3;
constexpr double kEccentricity2 = kFlattening * (2 - kFlattening);

constexpr double kImuPeriod = 0.02;  // s
constexpr int kImuPerKeyframe = 5;
constexpr int kKeyframesPerFix = 5;
constexpr double kFixDeviation = 0.1;  // m, stated
constexpr double kScoredShare = 0.1;   // of the way
constexpr double kDerivative = 0.05;   // s, of differences

struct Place {
  double latitude;   // rad
  double longitude;  // rad
};

Vector3d geocentric(const Place& place) {
  const double s = std::sin(place.latitude);
  const double n = kSemiMajor / std::sqrt(1 - kEccentricity2 * s * s);
  const double across = n * std::cos(place.latitude);
  return {across * std::cos(place.longitude), across * std::sin(place.longitude),
          n * (1 - kEccentricity2) * s};
}

/// Columns: east, north, up.
Matrix3d axes_at(const Place& place) {
  const double sp = std::sin(place.latitude);
  const double cp = std::cos(place.latitude);
  const double sl = std::sin(place.longitude);
  const double cl = std::cos(place.longitude);
  Matrix3d axes;
  axes << -sl, -sp * cl, cp * cl, cl, -sp * sl, cp * sl, 0, cp, sp;
  return axes;
}

/// m/s^2, on the ellipsoid (Somigliana).
double gravity_at(double latitude) {
  const double s = std::sin(latitude);
  return kEquatorGravity * (1 + kSomigliana * s * s) / std::sqrt(1 - kEccentricity2 * s * s);
}

/// North-east in long curves.
class Drive {
 public:
  explicit Drive(const LongDriveSettings& settings)
      : latitude_(settings.latitude * std::numbers::pi / 180), speed_(settings.speed) {}

  [[nodiscard]] Place place(double t) const {
    constexpr double kWeave = 300;       // m
    constexpr double kWeaveRate = 0.03;  // rad/s
    const double along = speed_ * t / std::numbers::sqrt2;
    const double across = kWeave * std::sin(kWeaveRate * t);
    return {latitude_ + (along + across) / kSemiMajor,
            (along - across) / (kSemiMajor * std::cos(latitude_))};
  }
  [[nodiscard]] Vector3d position(double t) const { return geocentric(place(t)); }
  [[nodiscard]] Vector3d velocity(double t) const {
    return (position(t + kDerivative) - position(t - kDerivative)) / (2 * kDerivative);
  }
  [[nodiscard]] Vector3d acceleration(double t) const {
    // Wider: differences of numbers of 6e6 m.
    constexpr double kWide = 0.5;
    return (position(t + kWide) - 2 * position(t) + position(t - kWide)) / (kWide * kWide);
  }
  /// Level, x along the way.
  [[nodiscard]] Matrix3d attitude(double t) const {
    const Vector3d up = axes_at(place(t)).col(2);
    Matrix3d r;
    r.col(0) = (velocity(t) - up * up.dot(velocity(t))).normalized();
    r.col(2) = up;
    r.col(1) = up.cross(r.col(0));
    return r;
  }
  [[nodiscard]] Vector3d angular_rate(double t) const {
    const SO3 before = SO3::from_matrix(attitude(t - kDerivative));
    const SO3 after = SO3::from_matrix(attitude(t + kDerivative));
    return (before.inverse() * after).log() / (2 * kDerivative) +
           attitude(t).transpose() * Vector3d(0, 0, kEarthRate);
  }
  [[nodiscard]] Vector3d specific_force(double t) const {
    const Vector3d earth(0, 0, kEarthRate);
    const Vector3d pull = -gravity_at(place(t).latitude) * axes_at(place(t)).col(2);
    return attitude(t).transpose() * (acceleration(t) + 2 * earth.cross(velocity(t)) - pull);
  }

 private:
  double latitude_;
  double speed_;
};

}  // namespace

LongDriveScore score_long_drive(const LongDriveSettings& settings) {
  const Drive drive(settings);
  const Vector3d origin = drive.position(0);
  const Matrix3d R_map_earth = axes_at(drive.place(0)).transpose();
  const auto truth = [&](double t) {
    return NavState{.R_map_body = SO3::from_matrix(R_map_earth * drive.attitude(t)),
                    .position = R_map_earth * (drive.position(t) - origin),
                    .velocity = R_map_earth * drive.velocity(t)};
  };
  estimation::FixedLagSmootherParameters parameters;
  parameters.gravity = gravity_at(drive.place(0).latitude);
  if (settings.earth) {
    parameters.earth = estimation::Earth::at_latitude(settings.latitude);
  }
  estimation::FixedLagSmoother smoother(parameters);
  estimation::StateVector deviations;
  deviations << Vector3d::Constant(0.1), Vector3d::Constant(1e-3), Vector3d::Constant(0.05),
      Vector3d::Constant(1e-4), Vector3d::Constant(0.02);
  smoother.initialise(0, truth(0), deviations.cwiseAbs2().asDiagonal());
  const int keyframes =
      static_cast<int>(settings.length / (settings.speed * kImuPeriod * kImuPerKeyframe));
  LongDriveScore score;
  int scored = 0;
  for (int k = 0; k < keyframes; ++k) {
    for (int i = 0; i < kImuPerKeyframe; ++i) {
      const double start = (k * kImuPerKeyframe + i) * kImuPeriod;
      const double middle = start + kImuPeriod / 2;
      smoother.add(estimation::ImuSample{.time = start,
                                         .duration = kImuPeriod,
                                         .angular_rate = drive.angular_rate(middle),
                                         .specific_force = drive.specific_force(middle)});
    }
    const double time = (k + 1) * kImuPerKeyframe * kImuPeriod;
    const NavState now = truth(time);
    if (k % kKeyframesPerFix == 0) {
      smoother.add(estimation::GpsMeasurement{
          .time = time,
          .position = now.position,
          .covariance = kFixDeviation * kFixDeviation * Matrix3d::Identity()});
    }
    smoother.update(time);
    if (k >= (1 - kScoredShare) * keyframes) {
      const NavState& found = smoother.state(smoother.keyframes() - 1);
      const Vector3d error = now.R_map_body * (found.R_map_body.inverse() * now.R_map_body).log();
      const Vector3d up = R_map_earth * axes_at(drive.place(time)).col(2);
      const double heading = error.dot(up);
      score.heading += heading * heading;
      score.tilt += (error - heading * up).squaredNorm();
      ++scored;
    }
  }
  score.heading = std::sqrt(score.heading / scored);
  score.tilt = std::sqrt(score.tilt / scored);
  return score;
}

}  // namespace pipescout::estimation_study
