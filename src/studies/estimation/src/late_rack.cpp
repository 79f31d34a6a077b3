// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/late_rack.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "pipescout/batch_estimation/batch_smoother.hpp"
#include "pipescout/estimation/fixed_lag_smoother.hpp"
#include "pipescout/simulation/body_motion.hpp"
#include "pipescout/simulation/imu_sensor.hpp"
#include "pipescout/simulation/uav.hpp"
#include "recorder.hpp"

namespace pipescout::estimation_study {
namespace {

using Eigen::Vector3d;
using estimation::GlobalStates;
using estimation::NavState;
using geometry::SE3;
using geometry::SO3;

constexpr double kImuPeriod = 0.01;  // s
constexpr int kImuPerKeyframe = 10;
constexpr int kKeyframesPerFix = 2;
constexpr double kFixNoise = 0.3;          // m
constexpr double kPoseNoise = 0.02;        // m
constexpr double kPoseAngleNoise = 0.005;  // rad
constexpr std::uint64_t kPurpose = 31;     // of draws

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

double nees(const GlobalStates& found, const GlobalStates& truth,
            const Eigen::Matrix<double, estimation::kGlobalSize, estimation::kGlobalSize>& all) {
  const geometry::Vector6d error = found.local(truth).segment<6>(estimation::kRackPosition);
  const geometry::Matrix6d covariance =
      all.block<6, 6>(estimation::kRackPosition, estimation::kRackPosition);
  return error.dot(covariance.llt().solve(error));
}

}  // namespace

LateRackScore score_late_rack(const LateRackSettings& settings, std::uint64_t seed) {
  internal::Draw draw = internal::make_draw(seed, kPurpose);
  estimation::FixedLagSmootherParameters parameters;
  const auto imu_parameters = [] {
    auto p = simulation::ImuParameters::industrial();
    p.period = kImuPeriod;
    return p;
  }();
  parameters.gravity = simulation::kGravity;
  parameters.imu_noise.gyro = imu_parameters.gyro.noise_density;
  parameters.imu_noise.accelerometer = imu_parameters.accelerometer.noise_density;
  parameters.global_deviations.rack_position = settings.position_deviation;
  parameters.global_deviations.rack_rotation = settings.rotation_deviation;
  parameters.globals.rack_position = {8, 0, 0};
  GlobalStates truth = parameters.globals;
  truth.rack_position += settings.position_deviation * draw.normals();
  truth.R_map_rack = truth.R_map_rack * SO3::exp(settings.rotation_deviation * draw.normals());
  const SE3 T_rack_map = SE3(truth.R_map_rack, truth.rack_position).inverse();

  simulation::ImuSensor imu(imu_parameters, seed);
  estimation::StateVector deviations;
  deviations << Vector3d::Constant(0.3), Vector3d::Constant(0.02), Vector3d::Constant(0.1),
      Vector3d::Constant(2e-3), Vector3d::Constant(0.05);
  const simulation::BodyMotion begin = motion_at(0);
  NavState first{.R_map_body = begin.T_map_body.rotation() * SO3::exp(0.02 * draw.normals()),
                 .position = begin.T_map_body.translation() + 0.3 * draw.normals(),
                 .velocity = begin.velocity + 0.1 * draw.normals()};
  estimation::FixedLagSmoother online(parameters);
  estimation::Recording recording{.first = first,
                                  .first_covariance = deviations.cwiseAbs2().asDiagonal()};
  online.initialise(0, first, recording.first_covariance);
  std::size_t offered = 0;
  const int keyframes = static_cast<int>(settings.duration / (kImuPeriod * kImuPerKeyframe));
  for (int k = 0; k <= keyframes; ++k) {
    const double time = k * kImuPeriod * kImuPerKeyframe;
    recording.times.push_back(time);
    const simulation::BodyMotion now = motion_at(time);
    if (k > 0 && k % kKeyframesPerFix == 0) {
      const estimation::GpsMeasurement fix{
          .time = time,
          .position = now.T_map_body.translation() + kFixNoise * draw.normals(),
          .covariance = kFixNoise * kFixNoise * Eigen::Matrix3d::Identity()};
      online.add(fix);
      recording.measurements.emplace_back(fix);
    }
    if (time >= settings.seen_from) {
      const SE3 T_rack_body = T_rack_map * now.T_map_body;
      const estimation::VisualPoseMeasurement pose{
          .time = time,
          .T_rack_body = SE3(T_rack_body.rotation() * SO3::exp(kPoseAngleNoise * draw.normals()),
                             T_rack_body.translation() + kPoseNoise * draw.normals()),
          .covariance = pose_covariance()};
      online.add(pose);
      recording.measurements.emplace_back(pose);
      ++offered;
    }
    online.update(time);
    if (k == keyframes) {
      break;
    }
    for (int i = 0; i < kImuPerKeyframe; ++i) {
      const double start = time + i * kImuPeriod;
      const simulation::BodyMotion middle = motion_at(start + kImuPeriod / 2);
      const simulation::ImuReading reading = imu.measure(
          {.angular_rate = middle.angular_rate, .specific_force = middle.specific_force()});
      const estimation::ImuSample sample{.time = start,
                                         .duration = kImuPeriod,
                                         .angular_rate = reading.angular_rate,
                                         .specific_force = reading.specific_force};
      online.add(sample);
      recording.imu.push_back(sample);
    }
  }

  LateRackScore score;
  score.online_nees = nees(online.globals(), truth, online.global_covariance());
  score.online_position = (online.globals().rack_position - truth.rack_position).norm();
  score.online_rotation = (truth.R_map_rack.inverse() * online.globals().R_map_rack).log().norm();
  const auto& counts = online.counts(estimation::FactorKind::kVisualPose);
  score.accepted_share =
      static_cast<double>(counts[static_cast<std::size_t>(estimation::Outcome::kAccepted)]) /
      static_cast<double>(offered);
  estimation::BatchSmoother batch(estimation::BatchSmootherParameters::like(parameters),
                                  std::move(recording));
  batch.solve();
  score.batch_nees = nees(batch.globals(), truth, batch.global_covariance());
  return score;
}

}  // namespace pipescout::estimation_study
