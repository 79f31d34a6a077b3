// SPDX-License-Identifier: Apache-2.0
#include "simulated_vehicle.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace pipescout::estimation::test {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

constexpr double kGravity = 9.81;
constexpr double kSize = 40;    // m, of the figure of eight
constexpr double kRampUp = 3;   // s, to full speed
constexpr double kStep = 1e-3;  // s, of numeric derivatives
constexpr double kOdometerScale = 1.004;
constexpr double kOdometerVariance = 1e-5;  // m^2/m

/// Integral of a smooth step from 0 to 1 over kRampUp.
double ramp(double t) {
  if (t <= 0) {
    return 0;
  }
  const double x = std::min(t / kRampUp, 1.0);
  return kRampUp * (x * x * x * x * (2.5 - 3 * x + x * x)) + std::max(t - kRampUp, 0.0);
}

geometry::Matrix6d covariance(double translation, double rotation) {
  geometry::Vector6d d;
  d << Vector3d::Constant(translation * translation), Vector3d::Constant(rotation * rotation);
  return d.asDiagonal();
}

}  // namespace

ImuNoise vehicle_imu_noise() {
  return {.gyro = 3e-4,
          .accelerometer = 3e-3,
          .gyro_bias = 2e-5,
          .accelerometer_bias = 3e-4,
          .integration = 1e-5};
}

double SimulatedVehicle::way_parameter(double time) const {
  const double moving = ramp(time - options_.standing) - ramp(time - options_.stop_from) +
                        ramp(time - options_.stop_until);
  // Speed varies along the figure; on the mean it is about this.
  return options_.speed / (1.6 * kSize) * moving;
}

Vector3d SimulatedVehicle::place(double time) const {
  const double u = way_parameter(time);
  Vector3d p(kSize * std::sin(u), 0.5 * kSize * std::sin(2 * u), 1.5 * (1 - std::cos(u)));
  if (options_.kind == VehicleOptions::Kind::kFly) {
    const double w = 6 * u;
    p +=
        Vector3d(0.8 * std::sin(1.7 * w), 0.6 * (1 - std::cos(1.3 * w)), 3 * u + 0.5 * std::sin(w));
  }
  return options_.origin + SO3::about_z(options_.heading) * p;
}

SO3 SimulatedVehicle::attitude(double time) const {
  const double u = way_parameter(time);
  const double dx = kSize * std::cos(u);
  const double dy = kSize * std::cos(2 * u);
  const double yaw = options_.heading + std::atan2(dy, dx);
  if (options_.kind == VehicleOptions::Kind::kFly) {
    return SO3::from_roll_pitch_yaw(
        {0.15 * std::sin(9 * u), 0.12 * (1 - std::cos(7 * u)), options_.heading + 1.2 * u});
  }
  return SO3::from_roll_pitch_yaw({0, -std::atan2(1.5 * std::sin(u), std::hypot(dx, dy)), yaw});
}

NavState SimulatedVehicle::truth(double time) const {
  NavState x;
  x.position = place(time);
  x.R_map_body = attitude(time);
  x.velocity = (place(time + kStep) - place(time - kStep)) / (2 * kStep);
  return x;
}

SimulatedVehicle::SimulatedVehicle(std::uint64_t seed, const VehicleOptions& options)
    : options_(options) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double deviation) {
    return Vector3d(deviation * normal(engine), deviation * normal(engine),
                    deviation * normal(engine));
  };
  const ImuNoise densities = vehicle_imu_noise();
  const double dt = 1 / options.imu_rate;
  Vector3d gyro_bias = noise(0.003);
  Vector3d force_bias = noise(0.03);
  const auto imu_count = static_cast<int>(options.duration * options.imu_rate);
  for (int i = 0; i < imu_count; ++i) {
    const double t = i * dt;
    const SO3 R = attitude(t);
    const Vector3d rate = (attitude(t - kStep).inverse() * attitude(t + kStep)).log() / (2 * kStep);
    const Vector3d acceleration =
        (place(t + kStep) - 2 * place(t) + place(t - kStep)) / (kStep * kStep);
    messages_.push_back(
        {t, ImuReading{t,
                       R.inverse() * (acceleration + Vector3d(0, 0, kGravity)) + force_bias +
                           noise(densities.accelerometer / std::sqrt(dt)),
                       rate + gyro_bias + noise(densities.gyro / std::sqrt(dt))}});
    gyro_bias += noise(densities.gyro_bias * std::sqrt(dt));
    force_bias += noise(densities.accelerometer_bias * std::sqrt(dt));
  }
  const auto every = [&](double period, auto&& make) {
    for (int i = 0; i * period < options.duration; ++i) {
      make(i * period);
    }
  };
  if (options.odometer) {
    double distance = 0;
    double error = 0;
    double way = 0;
    Vector3d before = place(0);
    every(0.02, [&](double t) {
      const double moved = (place(t) - before).norm();
      before = place(t);
      way += moved;
      distance += moved / kOdometerScale;
      error += std::sqrt(kOdometerVariance * moved) * normal(engine);
      messages_.push_back(
          {t + 0.002, OdometerReading{t, distance + error, kOdometerVariance * way}});
    });
  }
  if (options.gps) {
    every(0.2, [&](double t) {
      const double s = options.gps_deviation;
      messages_.push_back(
          {t + 0.05, GpsMeasurement{t, place(t) + noise(s), s * s * Eigen::Matrix3d::Identity()}});
    });
  }
  if (options.compass) {
    every(0.1, [&](double t) {
      messages_.push_back(
          {t + 0.01,
           HeadingMeasurement{t, attitude(t).roll_pitch_yaw().z() + 0.03 * normal(engine), 0.03}});
    });
  }
  if (options.vision) {
    every(0.1, [&](double t) {
      messages_.push_back(
          {t + 0.03, VisualPoseMeasurement{
                         t, SE3(attitude(t) * SO3::exp(noise(0.002)), place(t) + noise(0.01)),
                         covariance(0.01, 0.002)}});
    });
  }
  std::stable_sort(messages_.begin(), messages_.end(),
                   [](const Message& a, const Message& b) { return a.arrival < b.arrival; });
}

void deliver(StateEstimator& estimator, const AnyMessage& message) {
  std::visit([&](const auto& m) { estimator.add(m); }, message);
}

void deliver(StateEstimator& estimator, const SimulatedVehicle& vehicle, double from, double until,
             const Change& change, const After& after) {
  for (const Message& message : vehicle.messages()) {
    if (message.arrival < from || message.arrival >= until) {
      continue;
    }
    AnyMessage content = message.content;
    if (change && !change(content)) {
      continue;
    }
    deliver(estimator, content);
    if (after) {
      if (const auto estimate = estimator.estimate()) {
        after(*estimate);
      }
    }
  }
}

}  // namespace pipescout::estimation::test
