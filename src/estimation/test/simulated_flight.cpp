// SPDX-License-Identifier: Apache-2.0
#include "simulated_flight.hpp"

#include <cmath>

namespace pipescout::estimation::test {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

constexpr double kGravity = 9.81;

Vector3d rate_at(double t) {
  return {0.3 * std::sin(1.1 * t), 0.2 * std::cos(0.7 * t), 0.4 + 0.2 * std::sin(0.3 * t)};
}

/// Acceleration in the map whose integrals stay within some metres.
Vector3d acceleration_at(double t) {
  return {-1.5 * std::sin(0.8 * t), 1.2 * std::cos(0.9 * t), 0.5 * std::sin(1.3 * t)};
}

geometry::Matrix6d covariance(double translation, double rotation) {
  geometry::Vector6d d;
  d << Vector3d::Constant(translation * translation), Vector3d::Constant(rotation * rotation);
  return d.asDiagonal();
}

}  // namespace

FixedLagSmootherParameters flight_parameters() {
  FixedLagSmootherParameters parameters;
  parameters.imu_noise = {.gyro = 1e-3,
                          .accelerometer = 1e-2,
                          .gyro_bias = 1e-4,
                          .accelerometer_bias = 1e-3,
                          .integration = 1e-6};
  parameters.robustness.fill({});
  return parameters;
}

SimulatedFlight::SimulatedFlight(std::uint64_t seed, int keyframes,
                                 const GlobalStates& true_globals) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double deviation) {
    return Vector3d(deviation * normal(engine), deviation * normal(engine),
                    deviation * normal(engine));
  };
  const ImuNoise densities = flight_parameters().imu_noise;
  StateVector deviations;
  deviations << Vector3d::Constant(0.2), Vector3d::Constant(0.03), Vector3d::Constant(0.2),
      Vector3d::Constant(0.01), Vector3d::Constant(0.05);
  first_covariance = deviations.cwiseAbs2().asDiagonal();

  NavState x;
  x.position = Vector3d(1, 2, 3);
  x.velocity = Vector3d(1.5 / 0.8, 0, 0);
  x.gyro_bias = noise(0.01);
  x.accelerometer_bias = noise(0.05);
  const double dt = kStep / kImuPerKeyframe;
  const Eigen::Matrix3d shown_rate = true_globals.imu_scale.gyro.inverse();
  const Eigen::Matrix3d shown_force = true_globals.imu_scale.accelerometer.inverse();
  for (int k = 0; k < keyframes; ++k) {
    const double time = time_of(k);
    truth.push_back(x);
    gps.push_back({time,
                   x.position + x.R_map_body * true_globals.gps_lever_arm + noise(kPositionNoise),
                   kPositionNoise * kPositionNoise * Eigen::Matrix3d::Identity()});
    const SO3 R_rack_map = true_globals.R_map_rack.inverse();
    vision.push_back(
        {time,
         SE3(R_rack_map * x.R_map_body * SO3::exp(noise(kAngleNoise)),
             R_rack_map * (x.position - true_globals.rack_position) + noise(kPoseNoise)),
         covariance(kPoseNoise, kAngleNoise)});
    RelativePoseMeasurement moved;
    if (k > 0) {
      const SE3 T = truth[truth.size() - 2].T_map_body().inverse() * x.T_map_body();
      moved = {time_of(k - 1), time,
               SE3(T.rotation() * SO3::exp(noise(kTurnNoise)),
                   T.translation() + T.rotation() * noise(kMoveNoise)),
               covariance(kMoveNoise, kTurnNoise)};
    }
    odometry.push_back(moved);
    for (int i = 0; i < kImuPerKeyframe; ++i) {
      const double at = time + i * dt;
      const Vector3d rate = rate_at(at);
      // Constant in the map over the sample: the body's mean turn is the one half way.
      const Vector3d force = (x.R_map_body * SO3::exp(0.5 * dt * rate)).inverse() *
                             (acceleration_at(at) + Vector3d(0, 0, kGravity));
      const Vector3d gained = dt * acceleration_at(at);
      imu.push_back({at, dt,
                     shown_rate * rate + x.gyro_bias + noise(densities.gyro / std::sqrt(dt)),
                     shown_force * force + x.accelerometer_bias +
                         noise(densities.accelerometer / std::sqrt(dt))});
      x.position += dt * (x.velocity + 0.5 * gained);
      x.velocity += gained;
      x.R_map_body = x.R_map_body * SO3::exp(dt * rate);
      x.gyro_bias += noise(densities.gyro_bias * std::sqrt(dt));
      x.accelerometer_bias += noise(densities.accelerometer_bias * std::sqrt(dt));
    }
  }
  first = truth[0].retract(
      deviations.cwiseProduct(StateVector::NullaryExpr([&] { return normal(engine); })));
}

const UpdateReport& SimulatedFlight::feed(FixedLagSmoother& smoother, int keyframe, bool with_gps,
                                          bool with_vision, bool with_odometry) const {
  const auto k = static_cast<std::size_t>(keyframe);
  if (k > 0) {
    for (std::size_t i = (k - 1) * kImuPerKeyframe; i < k * kImuPerKeyframe; ++i) {
      smoother.add(imu[i]);
    }
    if (with_odometry) {
      smoother.add(odometry[k]);
    }
  }
  if (with_gps) {
    smoother.add(gps[k]);
  }
  if (with_vision) {
    smoother.add(vision[k]);
  }
  return smoother.update(time_of(keyframe));
}

}  // namespace pipescout::estimation::test
