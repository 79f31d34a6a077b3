// SPDX-License-Identifier: Apache-2.0
#include "innovation.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace pipescout::estimation_study::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using estimation::NavState;
using estimation::StateMatrix;

constexpr double kKept = 5;  // s, of readings: above any lag of a measurement

double nis_of(const NavState& state, const StateMatrix& covariance, const Vector3d& lever,
              const Vector3d& measured, const Matrix3d& measured_covariance) {
  const Matrix3d R = state.R_map_body.matrix();
  Eigen::Matrix<double, 3, 6> derivative;
  derivative << Matrix3d::Identity(), -R * geometry::skew(lever);
  const Vector3d innovation = measured - state.position - R * lever;
  const Matrix3d spread =
      derivative * covariance.topLeftCorner<6, 6>() * derivative.transpose() + measured_covariance;
  return innovation.dot(spread.ldlt().solve(innovation));
}

}  // namespace

void Innovations::add(const estimation::ImuReading& reading) {
  if (!readings_.empty() && reading.time <= readings_.back().time) {
    return;
  }
  readings_.push_back(reading);
  while (readings_.front().time < reading.time - kKept) {
    readings_.pop_front();
  }
}

std::optional<Innovations::Prediction> Innovations::predict(
    const estimation::FixedLagSmoother& smoother, double time) const {
  std::size_t keyframe = smoother.keyframes();
  while (keyframe > 0 && smoother.time(keyframe - 1) > time) {
    --keyframe;
  }
  if (keyframe == 0 || readings_.empty() || readings_.back().time < time) {
    return std::nullopt;
  }
  --keyframe;
  const double begin = smoother.time(keyframe);
  const NavState& state = smoother.state(keyframe);
  const StateMatrix covariance = smoother.covariance(keyframe);
  estimation::ImuPreintegration carried(estimation::ImuMotion(
      state.gyro_bias, state.accelerometer_bias, smoother.globals().imu_scale));
  for (std::size_t i = 1; i < readings_.size(); ++i) {
    const double from = std::max(readings_[i - 1].time, begin);
    const double to = std::min(readings_[i].time, time);
    if (to > from) {
      carried.integrate(
          R_body_imu_ * (readings_[i - 1].angular_rate + readings_[i].angular_rate) / 2,
          R_body_imu_ * (readings_[i - 1].specific_force + readings_[i].specific_force) / 2,
          to - from, noise_);
    }
  }
  if (carried.motion().duration() <= 0) {
    return Prediction{state, covariance};
  }
  StateMatrix derivative;
  Prediction result;
  result.state = carried.motion().propagate(state, gravity_, &derivative);
  // The preintegration's covariance has position and velocity in the axes of its beginning.
  StateMatrix turned = StateMatrix::Identity();
  turned.block<3, 3>(estimation::kPosition, estimation::kPosition) = state.R_map_body.matrix();
  turned.block<3, 3>(estimation::kVelocity, estimation::kVelocity) = state.R_map_body.matrix();
  result.covariance = derivative * covariance * derivative.transpose() +
                      turned * carried.covariance() * turned.transpose();
  return result;
}

std::optional<double> Innovations::nis(const estimation::FixedLagSmoother& smoother,
                                       const Reading& reading) const {
  if (const auto* gps = std::get_if<estimation::GpsMeasurement>(&reading)) {
    if (const auto predicted = predict(smoother, gps->time)) {
      return nis_of(predicted->state, predicted->covariance, smoother.globals().gps_lever_arm,
                    gps->position, gps->covariance);
    }
  }
  if (const auto* weld = std::get_if<estimation::WeldMeasurement>(&reading)) {
    if (const auto predicted = predict(smoother, weld->time)) {
      const Vector3d& d = weld->direction;
      const double along = weld->along_deviation * weld->along_deviation;
      const double across = weld->across_deviation * weld->across_deviation;
      const Matrix3d covariance =
          across * Matrix3d::Identity() + (along - across) * d * d.transpose();
      return nis_of(predicted->state, predicted->covariance, weld->sensor, weld->position,
                    covariance);
    }
  }
  return std::nullopt;
}

}  // namespace pipescout::estimation_study::internal
