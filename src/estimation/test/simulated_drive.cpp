// SPDX-License-Identifier: Apache-2.0
#include "simulated_drive.hpp"

#include <cmath>
#include <random>

namespace pipescout::estimation::test {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

constexpr double kGravity = 9.81;
constexpr double kDt = SimulatedDrive::kStep / SimulatedDrive::kImuPerKeyframe;

Vector3d rate_at(double t) {
  return {0.05 * std::sin(0.9 * t), 0.04 * std::cos(1.3 * t), 0.1 + 0.5 * std::sin(0.5 * t)};
}

/// Of the wheel, m/s.
double speed_at(double t) {
  return 2 - std::cos(0.4 * t);
}

}  // namespace

ImuScale wrong_scale() {
  ImuScale scale;
  scale.gyro << 1.005, 0.003, -0.005, 0.004, 0.995, 0.003, -0.003, 0.006, 1.01;
  scale.accelerometer << 0.997, -0.004, 0.003, 0.003, 1.003, -0.005, 0.006, 0.003, 1.002;
  return scale;
}

FixedLagSmootherParameters drive_parameters() {
  FixedLagSmootherParameters parameters;
  parameters.imu_noise = {.gyro = 1e-3,
                          .accelerometer = 1e-2,
                          .gyro_bias = 1e-5,
                          .accelerometer_bias = 1e-4,
                          .integration = 1e-6};
  parameters.robustness.fill({});
  return parameters;
}

SimulatedDrive::SimulatedDrive(std::uint64_t seed, int keyframes, const GlobalStates& true_globals,
                               const Vector3d& wheel) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double deviation) {
    return Vector3d(deviation * normal(engine), deviation * normal(engine),
                    deviation * normal(engine));
  };
  const ImuNoise densities = drive_parameters().imu_noise;
  StateVector deviations;
  deviations << Vector3d::Constant(0.1), Vector3d::Constant(0.02), Vector3d::Constant(0.1),
      Vector3d::Constant(0.01), Vector3d::Constant(0.05);
  first_covariance = deviations.cwiseAbs2().asDiagonal();
  const Vector3d travel = SO3::about_z(true_globals.mount_yaw) *
                          SO3::about_y(true_globals.mount_pitch) * Vector3d::UnitX();
  const auto velocity_at = [&](double t, const SO3& R_map_body) -> Vector3d {
    return R_map_body * (speed_at(t) * travel - rate_at(t).cross(wheel));
  };

  const Eigen::Matrix3d shown_rate = true_globals.imu_scale.gyro.inverse();
  const Eigen::Matrix3d shown_force = true_globals.imu_scale.accelerometer.inverse();

  // The motion first, sample by sample: the antenna looks ahead of its stamp.
  const auto ahead = static_cast<std::size_t>(std::lround(true_globals.gps_time_offset / kDt));
  const std::size_t samples = static_cast<std::size_t>(keyframes) * kImuPerKeyframe + ahead;
  std::vector<NavState> motion;
  NavState x;
  x.gyro_bias = noise(0.01);
  x.accelerometer_bias = noise(0.05);
  x.velocity = velocity_at(0, x.R_map_body);
  for (std::size_t i = 0; i < samples; ++i) {
    motion.push_back(x);
    const double time = kDt * static_cast<double>(i);
    const Vector3d rate = rate_at(time + 0.5 * kDt);
    const SO3 next = x.R_map_body * SO3::exp(kDt * rate);
    const Vector3d gained = velocity_at(time + kDt, next) - x.velocity;
    const Vector3d force = (x.R_map_body * SO3::exp(0.5 * kDt * rate)).inverse() *
                           (gained / kDt + Vector3d(0, 0, kGravity));
    imu.push_back({time, kDt,
                   shown_rate * rate + x.gyro_bias + noise(densities.gyro / std::sqrt(kDt)),
                   shown_force * force + x.accelerometer_bias +
                       noise(densities.accelerometer / std::sqrt(kDt))});
    x.position += kDt * (x.velocity + 0.5 * gained);
    x.velocity += gained;
    x.R_map_body = next;
    x.gyro_bias += noise(densities.gyro_bias * std::sqrt(kDt));
    x.accelerometer_bias += noise(densities.accelerometer_bias * std::sqrt(kDt));
  }

  for (int k = 0; k < keyframes; ++k) {
    const std::size_t i = static_cast<std::size_t>(k) * kImuPerKeyframe;
    const double time = time_of(k);
    const NavState& here = motion[i];
    const NavState& later = motion[i + ahead];
    // As the IMU has it, over one sample.
    const Vector3d& rate = imu[i].angular_rate;
    truth.push_back(here);
    gps.push_back({.time = time,
                   .position = later.position + later.R_map_body * true_globals.gps_lever_arm +
                               noise(kPositionNoise),
                   .covariance = kPositionNoise * kPositionNoise * Eigen::Matrix3d::Identity(),
                   .angular_rate = rate});
    const SO3 R_rack_map = true_globals.R_map_rack.inverse();
    geometry::Vector6d pose_variances;
    pose_variances << Vector3d::Constant(kPoseNoise * kPoseNoise),
        Vector3d::Constant(kAngleNoise * kAngleNoise);
    vision.push_back(
        {.time = time,
         .T_rack_body =
             SE3(R_rack_map * here.R_map_body * SO3::exp(noise(kAngleNoise)),
                 R_rack_map * (here.position - true_globals.rack_position) + noise(kPoseNoise)),
         .covariance = pose_variances.asDiagonal()});
    non_holonomic.push_back({.time = time,
                             .lateral_deviation = kSideways,
                             .vertical_deviation = kSideways,
                             .sensor = wheel,
                             .angular_rate = rate});
    OdometerMeasurement moved;
    if (k > 0) {
      double distance = 0;
      for (int j = 0; j < kImuPerKeyframe; ++j) {
        distance += kDt * speed_at(time - kStep + (j + 0.5) * kDt);
      }
      moved = {.from_time = time_of(k - 1),
               .to_time = time,
               .distance = distance / true_globals.odometer_scale + kDistanceNoise * normal(engine),
               .standard_deviation = kDistanceNoise,
               .across_deviation = kSlip,
               .sensor = wheel};
    }
    odometer.push_back(moved);
  }
  first = truth[0].retract(
      deviations.cwiseProduct(StateVector::NullaryExpr([&] { return normal(engine); })));
}

}  // namespace pipescout::estimation::test
