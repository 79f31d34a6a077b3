// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/late_rack.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "pipescout/simulation/body_motion.hpp"
#include "pipescout/simulation/imu_sensor.hpp"
#include "pipescout/simulation/uav.hpp"
#include "recorder.hpp"

namespace pipescout::estimation_study {
namespace {

using Eigen::Vector3d;
using estimation::GlobalStates;
using geometry::SE3;
using geometry::SO3;

constexpr double kImuPeriod = 0.01;  // s
constexpr int kImuPerKeyframe = 10;
constexpr int kKeyframesPerFix = 2;
constexpr double kFixNoise = 0.3;          // m
constexpr double kPoseNoise = 0.02;        // m
constexpr double kPoseAngleNoise = 0.005;  // rad
// Of what is known at the beginning: m, rad, m/s, rad/s, m/s^2.
constexpr double kFirstPosition = 0.3;
constexpr double kFirstRotation = 0.02;
constexpr double kFirstVelocity = 0.1;
constexpr double kFirstGyroBias = 2e-3;
constexpr double kFirstAccelerometerBias = 0.05;
constexpr std::uint64_t kPurpose = 31;  // of draws

/// Roll, pitch, yaw of a body that weaves, and its rates.
Vector3d angles_at(double t) {
  return {0.25 * std::sin(0.9 * t), 0.2 * std::sin(0.7 * t + 1.0),
          0.15 * t + 0.5 * std::sin(0.3 * t)};
}
Vector3d angle_rates_at(double t) {
  return {0.225 * std::cos(0.9 * t), 0.14 * std::cos(0.7 * t + 1.0),
          0.15 + 0.15 * std::cos(0.3 * t)};
}

simulation::BodyMotion motion_at(double t) {
  simulation::BodyMotion m;
  m.time = t;
  const Vector3d a = angles_at(t);
  const Vector3d d = angle_rates_at(t);
  const Vector3d position(6 * std::sin(0.4 * t), 5 * std::cos(0.3 * t), 4 + std::sin(0.5 * t));
  m.T_map_body = SE3(SO3::from_roll_pitch_yaw(a), position);
  m.velocity = Vector3d(2.4 * std::cos(0.4 * t), -1.5 * std::sin(0.3 * t), 0.5 * std::cos(0.5 * t));
  m.acceleration =
      Vector3d(-0.96 * std::sin(0.4 * t), -0.45 * std::cos(0.3 * t), -0.25 * std::sin(0.5 * t));
  // Kinematics of Euler angles (Titterton and Weston, 2004, section 3.6.3).
  m.angular_rate = {d.x() - d.z() * std::sin(a.y()),
                    d.y() * std::cos(a.x()) + d.z() * std::sin(a.x()) * std::cos(a.y()),
                    -d.y() * std::sin(a.x()) + d.z() * std::cos(a.x()) * std::cos(a.y())};
  return m;
}

geometry::Matrix6d pose_covariance() {
  geometry::Vector6d variances;
  variances << Vector3d::Constant(kPoseNoise * kPoseNoise),
      Vector3d::Constant(kPoseAngleNoise * kPoseAngleNoise);
  return variances.asDiagonal();
}

}  // namespace

std::vector<estimation::AnyFactor> LateRackFlight::measurements() const {
  std::vector<estimation::AnyFactor> all(gps.begin(), gps.end());
  all.insert(all.end(), vision.begin(), vision.end());
  return all;
}

LateRackFlight fly_to_late_rack(const LateRackSettings& settings, std::uint64_t seed) {
  internal::Draw draw = internal::make_draw(seed, kPurpose);
  LateRackFlight flight;
  estimation::FixedLagSmootherParameters& parameters = flight.parameters;
  auto imu_parameters = simulation::ImuParameters::industrial();
  imu_parameters.period = kImuPeriod;
  parameters.gravity = simulation::kGravity;
  parameters.imu_noise.gyro = imu_parameters.gyro.noise_density;
  parameters.imu_noise.accelerometer = imu_parameters.accelerometer.noise_density;
  parameters.global_deviations.rack_position = settings.position_deviation;
  parameters.global_deviations.rack_rotation = settings.rotation_deviation;
  parameters.globals.rack_position = {8, 0, 0};
  GlobalStates& truth = flight.truth = parameters.globals;
  truth.rack_position += settings.position_deviation * draw.normals();
  truth.R_map_rack = truth.R_map_rack * SO3::exp(settings.rotation_deviation * draw.normals());
  const SE3 T_rack_map = SE3(truth.R_map_rack, truth.rack_position).inverse();

  estimation::StateVector deviations;
  deviations << Vector3d::Constant(kFirstPosition), Vector3d::Constant(kFirstRotation),
      Vector3d::Constant(kFirstVelocity), Vector3d::Constant(kFirstGyroBias),
      Vector3d::Constant(kFirstAccelerometerBias);
  flight.first_covariance = deviations.cwiseAbs2().asDiagonal();
  const simulation::BodyMotion begin = motion_at(0);
  flight.first = {
      .R_map_body = begin.T_map_body.rotation() * SO3::exp(kFirstRotation * draw.normals()),
      .position = begin.T_map_body.translation() + kFirstPosition * draw.normals(),
      .velocity = begin.velocity + kFirstVelocity * draw.normals()};

  simulation::ImuSensor imu(imu_parameters, seed);
  const int keyframes = static_cast<int>(settings.duration / (kImuPeriod * kImuPerKeyframe));
  for (int k = 0; k <= keyframes; ++k) {
    const double time = k * kImuPeriod * kImuPerKeyframe;
    flight.times.push_back(time);
    const simulation::BodyMotion now = motion_at(time);
    if (k > 0 && k % kKeyframesPerFix == 0) {
      flight.gps.push_back({.time = time,
                            .position = now.T_map_body.translation() + kFixNoise * draw.normals(),
                            .covariance = kFixNoise * kFixNoise * Eigen::Matrix3d::Identity()});
    }
    if (time >= settings.seen_from) {
      const SE3 T_rack_body = T_rack_map * now.T_map_body;
      flight.vision.push_back(
          {.time = time,
           .T_rack_body = SE3(T_rack_body.rotation() * SO3::exp(kPoseAngleNoise * draw.normals()),
                              T_rack_body.translation() + kPoseNoise * draw.normals()),
           .covariance = pose_covariance()});
    }
    for (int i = 0; i < kImuPerKeyframe && k < keyframes; ++i) {
      const double start = time + i * kImuPeriod;
      const simulation::BodyMotion middle = motion_at(start + kImuPeriod / 2);
      const simulation::ImuReading reading = imu.measure(
          {.angular_rate = middle.angular_rate, .specific_force = middle.specific_force()});
      flight.imu.push_back({.time = start,
                            .duration = kImuPeriod,
                            .angular_rate = reading.angular_rate,
                            .specific_force = reading.specific_force});
    }
  }
  return flight;
}

double rack_nees(
    const GlobalStates& found, const GlobalStates& truth,
    const Eigen::Matrix<double, estimation::kGlobalSize, estimation::kGlobalSize>& covariance) {
  const geometry::Vector6d error = found.local(truth).segment<6>(estimation::kRackPosition);
  const geometry::Matrix6d of_rack =
      covariance.block<6, 6>(estimation::kRackPosition, estimation::kRackPosition);
  return error.dot(of_rack.llt().solve(error));
}

LateRackScore score_late_rack(const LateRackFlight& flight) {
  estimation::FixedLagSmoother smoother(flight.parameters);
  smoother.initialise(flight.times.front(), flight.first, flight.first_covariance);
  const auto feed = [&](const auto& list, std::size_t& next, double until) {
    for (; next < list.size() && list[next].time < until; ++next) {
      smoother.add(list[next]);
    }
  };
  std::size_t imu = 0;
  std::size_t gps = 0;
  std::size_t vision = 0;
  constexpr double kSame = 1e-6;  // s
  for (const double time : flight.times) {
    feed(flight.imu, imu, time - kSame);
    feed(flight.gps, gps, time + kSame);
    feed(flight.vision, vision, time + kSame);
    smoother.update(time);
  }
  const GlobalStates& found = smoother.globals();
  const auto accepted =
      smoother.counts(estimation::FactorKind::kVisualPose)[static_cast<std::size_t>(
          estimation::Outcome::kAccepted)];
  return {
      .nees = rack_nees(found, flight.truth, smoother.global_covariance()),
      .position = (found.rack_position - flight.truth.rack_position).norm(),
      .rotation = (flight.truth.R_map_rack.inverse() * found.R_map_rack).log().norm(),
      .accepted_share = static_cast<double>(accepted) / static_cast<double>(flight.vision.size())};
}

}  // namespace pipescout::estimation_study
