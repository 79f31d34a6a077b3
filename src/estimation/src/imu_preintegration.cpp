// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/imu_preintegration.hpp"

#include "pipescout/validation/check.hpp"

namespace pipescout::estimation {
namespace {

using validation::require;

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::skew;
using geometry::SO3;

/// One sample's rotation and velocity, and what they depend on.
struct SampleMotion {
  SO3 rotation;
  Vector3d velocity;            // in the frame at the beginning of the preintegration
  Matrix3d rotation_by_rate;    // right, of `rotation` by the angular rate
  Matrix3d velocity_by_before;  // of `velocity` by the rotation before the sample (right)
  Matrix3d velocity_by_rate;
  Matrix3d velocity_by_force;
};

SampleMotion sample_motion(const SO3& before, const Vector3d& rate, const Vector3d& force,
                           double duration) {
  const Vector3d half_turn = 0.5 * duration * rate;
  const SO3 half = SO3::exp(half_turn);
  const Matrix3d middle = (before * half).matrix();
  const Matrix3d by_turn = -duration * middle * skew(force);
  const Vector3d turn = duration * rate;
  return {.rotation = half * half,
          .velocity = duration * (middle * force),
          .rotation_by_rate = duration * SO3::right_jacobian(turn),
          .velocity_by_before = by_turn * half.matrix().transpose(),
          .velocity_by_rate = 0.5 * duration * by_turn * SO3::right_jacobian(half_turn),
          .velocity_by_force = duration * middle};
}

/// Derivatives by the rate and the force become those by what is measured of them.
void take_as_measured(const ImuScale& scale, SampleMotion& sample) {
  sample.rotation_by_rate *= scale.gyro;
  sample.velocity_by_rate *= scale.gyro;
  sample.velocity_by_force *= scale.accelerometer;
}

/// From a derivative by a rate or a force to that by its scale; `unscaled` is what is multiplied.
Eigen::Matrix<double, 3, 9> by_scale(const Matrix3d& derivative, const Vector3d& unscaled) {
  Eigen::Matrix<double, 3, 9> result;
  for (int row = 0; row < 3; ++row) {
    result.middleCols<3>(3 * row) = derivative.col(row) * unscaled.transpose();
  }
  return result;
}

/// The derivatives of a motion, [position; rotation; velocity], after one more sample, whose own
/// rotation and velocity change as said.
template <int N>
void advance(const SampleMotion& sample, double duration,
             const Eigen::Matrix<double, 3, N>& rotation_by,
             const Eigen::Matrix<double, 3, N>& velocity_by, Eigen::Matrix<double, 9, N>& motion) {
  auto position = motion.template topRows<3>();
  auto rotation = motion.template middleRows<3>(3);
  auto velocity = motion.template bottomRows<3>();
  const Eigen::Matrix<double, 3, N> gained = sample.velocity_by_before * rotation + velocity_by;
  position += duration * velocity + 0.5 * duration * gained;
  velocity += gained;
  rotation = (sample.rotation.matrix().transpose() * rotation + rotation_by).eval();
}

}  // namespace

void ImuNoise::validate() const {
  require("imu_noise.gyro", gyro, gyro >= 1e-9 && gyro <= 10, "[1e-9, 10]");
  require("imu_noise.accelerometer", accelerometer, accelerometer >= 1e-9 && accelerometer <= 1000,
          "[1e-9, 1000]");
  require("imu_noise.gyro_bias", gyro_bias, gyro_bias >= 1e-9 && gyro_bias <= 1, "[1e-9, 1]");
  require("imu_noise.accelerometer_bias", accelerometer_bias,
          accelerometer_bias >= 1e-9 && accelerometer_bias <= 100, "[1e-9, 100]");
  require("imu_noise.integration", integration, integration >= 1e-9 && integration <= 1,
          "[1e-9, 1]");
}

void ImuMotion::integrate(const Vector3d& angular_rate, const Vector3d& specific_force,
                          double duration) {
  const Vector3d rate = angular_rate - gyro_bias_;
  const Vector3d force = specific_force - accelerometer_bias_;
  SampleMotion sample =
      scaled_ ? sample_motion(rotation_, scale_.gyro * rate, scale_.accelerometer * force, duration)
              : sample_motion(rotation_, rate, force, duration);
  if (scaled_) {
    Eigen::Matrix<double, 3, kImuScaleSize> rotation_by;
    Eigen::Matrix<double, 3, kImuScaleSize> velocity_by;
    rotation_by << by_scale(sample.rotation_by_rate, rate), Eigen::Matrix<double, 3, 9>::Zero();
    velocity_by << by_scale(sample.velocity_by_rate, rate),
        by_scale(sample.velocity_by_force, force);
    advance(sample, duration, rotation_by, velocity_by, scale_jacobian_);
    take_as_measured(scale_, sample);
  }
  Eigen::Matrix<double, 3, 6> rotation_by;
  Eigen::Matrix<double, 3, 6> velocity_by;
  rotation_by << -sample.rotation_by_rate, Matrix3d::Zero();
  velocity_by << -sample.velocity_by_rate, -sample.velocity_by_force;
  advance(sample, duration, rotation_by, velocity_by, bias_jacobian_);

  position_ += duration * (velocity_ + 0.5 * sample.velocity);
  velocity_ += sample.velocity;
  rotation_ = rotation_ * sample.rotation;
  duration_ += duration;
}

Eigen::Matrix<double, 9, 1> ImuMotion::correction(const NavState& start,
                                                  const ImuScale& scale) const {
  Eigen::Matrix<double, 6, 1> bias_change;
  bias_change << start.gyro_bias - gyro_bias_, start.accelerometer_bias - accelerometer_bias_;
  Eigen::Matrix<double, 9, 1> sum = bias_jacobian_ * bias_change;
  if (scaled_) {
    sum += scale_jacobian_ * scale_.local(scale);
  }
  return sum;
}

NavState ImuMotion::propagate(const NavState& start, const ImuScale& scale, const Gravity& gravity,
                              StateMatrix* derivative, ScaleJacobian* by_scale) const {
  const Eigen::Matrix<double, 9, 1> correction = this->correction(start, scale);
  const Vector3d moved = position_ + correction.head<3>();
  const Vector3d turn = correction.segment<3>(3);
  const SO3 turned = rotation_ * SO3::exp(turn);
  const Vector3d gained = velocity_ + correction.tail<3>();
  const Vector3d fall = duration_ * gravity.acceleration(start.position, start.velocity);
  const Matrix3d r = start.R_map_body.matrix();

  NavState end = start;
  end.position += duration_ * (start.velocity + 0.5 * fall) + r * moved;
  end.velocity += fall + r * gained;
  end.R_map_body = start.R_map_body * turned;
  if (derivative != nullptr) {
    auto& d = *derivative;
    d.setIdentity();
    d.block<3, 3>(kPosition, kRotation) = -r * skew(moved);
    d.block<3, 3>(kPosition, kVelocity).diagonal().setConstant(duration_);
    d.block<3, 6>(kPosition, kGyroBias) = r * bias_jacobian_.topRows<3>();
    d.block<3, 3>(kRotation, kRotation) = turned.matrix().transpose();
    d.block<3, 6>(kRotation, kGyroBias) =
        SO3::right_jacobian(turn) * bias_jacobian_.middleRows<3>(3);
    d.block<3, 3>(kVelocity, kRotation) = -r * skew(gained);
    d.block<3, 6>(kVelocity, kGyroBias) = r * bias_jacobian_.bottomRows<3>();
  }
  if (by_scale != nullptr && scaled_) {
    by_scale->topRows<3>() = r * scale_jacobian_.topRows<3>();
    by_scale->middleRows<3>(3) = SO3::right_jacobian(turn) * scale_jacobian_.middleRows<3>(3);
    by_scale->bottomRows<3>() = r * scale_jacobian_.bottomRows<3>();
  }
  return end;
}

void ImuPreintegration::integrate(const Vector3d& angular_rate, const Vector3d& specific_force,
                                  double duration, const ImuNoise& noise) {
  Vector3d rate = angular_rate - motion_.gyro_bias();
  Vector3d force = specific_force - motion_.accelerometer_bias();
  if (motion_.scaled()) {
    rate = (motion_.scale().gyro * rate).eval();
    force = (motion_.scale().accelerometer * force).eval();
  }
  SampleMotion sample = sample_motion(motion_.rotation(), rate, force, duration);
  if (motion_.scaled()) {
    take_as_measured(motion_.scale(), sample);
  }
  // The transition is the identity but for these rows, by rotation, velocity and biases.
  Eigen::Matrix<double, 3, 9> of_velocity;  // by rotation, gyro bias, accelerometer bias
  of_velocity << sample.velocity_by_before, -sample.velocity_by_rate, -sample.velocity_by_force;
  const Matrix3d of_rotation = sample.rotation.matrix().transpose();

  // F P, then (F P) F^T: the same operation on rows and on columns.
  const auto transition = [&](auto&& rows) {
    Eigen::Matrix<double, 3, kStateSize> change =
        of_velocity.leftCols<3>() * rows.template middleRows<3>(kRotation);
    change.noalias() += of_velocity.rightCols<6>() * rows.template bottomRows<6>();
    rows.template middleRows<3>(kPosition) +=
        duration * rows.template middleRows<3>(kVelocity) + 0.5 * duration * change;
    rows.template middleRows<3>(kVelocity) += change;
    rows.template middleRows<3>(kRotation) =
        (of_rotation * rows.template middleRows<3>(kRotation) -
         sample.rotation_by_rate * rows.template middleRows<3>(kGyroBias))
            .eval();
  };
  transition(covariance_);
  covariance_.transposeInPlace();
  transition(covariance_);

  // Noise of the rate and of the force acts as an error of the biases does during this sample.
  const double rate_variance = noise.gyro * noise.gyro / duration;
  const double force_variance = noise.accelerometer * noise.accelerometer / duration;
  Eigen::Matrix<double, 9, 6> by_noise;
  by_noise << 0.5 * duration * sample.velocity_by_rate, 0.5 * duration * sample.velocity_by_force,
      sample.rotation_by_rate, Matrix3d::Zero(), sample.velocity_by_rate, sample.velocity_by_force;
  covariance_.topLeftCorner<9, 9>().noalias() +=
      rate_variance * by_noise.leftCols<3>() * by_noise.leftCols<3>().transpose() +
      force_variance * by_noise.rightCols<3>() * by_noise.rightCols<3>().transpose();
  covariance_.diagonal().segment<3>(kPosition).array() +=
      duration * noise.integration * noise.integration;
  covariance_.diagonal().segment<3>(kGyroBias).array() +=
      duration * noise.gyro_bias * noise.gyro_bias;
  covariance_.diagonal().segment<3>(kAccelerometerBias).array() +=
      duration * noise.accelerometer_bias * noise.accelerometer_bias;
  motion_.integrate(angular_rate, specific_force, duration);
}

void ImuPreintegration::add_turn_noise(const Vector3d& axis, double density, double duration) {
  covariance_.block<3, 3>(kRotation, kRotation) +=
      duration * density * density * axis * axis.transpose();
}

}  // namespace pipescout::estimation
