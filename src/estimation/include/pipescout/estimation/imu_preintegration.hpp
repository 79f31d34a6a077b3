// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/gravity.hpp"
#include "pipescout/estimation/state.hpp"

/// Preintegration of an inertial measurement unit on the manifold: Forster, Carlone, Dellaert and
/// Scaramuzza, "On-Manifold Preintegration for Real-Time Visual-Inertial Odometry", IEEE T-RO
/// 33(1), 2017. Equation numbers are those of that paper. Two differences: the biases are random
/// walks within the interval and their covariance with the motion is kept, and a specific force is
/// rotated by the attitude at the middle of its sample instead of at its beginning.
namespace pipescout::estimation {

/// Mean angular rate and specific force over [time, time + duration).
struct ImuSample {
  double time = 0;                                           ///< s
  double duration = 0;                                       ///< s, > 0
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();    ///< rad/s, in the body
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();  ///< m/s^2, in the body
};

/// Densities of white noise and of the biases' random walks. The defaults are those of a small
/// MEMS unit.
struct ImuNoise {
  double gyro = 1.7e-4;              ///< rad/s/sqrt(Hz), in [1e-9, 10]
  double accelerometer = 2e-3;       ///< m/s^2/sqrt(Hz), in [1e-9, 1000]
  double gyro_bias = 2e-5;           ///< rad/s^2/sqrt(Hz), in [1e-9, 1]
  double accelerometer_bias = 3e-3;  ///< m/s^3/sqrt(Hz), in [1e-9, 100]
  double integration = 1e-5;  ///< m/sqrt(s): discretisation error; keeps the covariance of one
                              ///< sample regular. In [1e-9, 1]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// The preintegrated motion between two times, in the body frame of the first: Delta p, R, v of
/// equation (33), with derivatives with respect to the biases and without a covariance. If the
/// scale of the IMU is estimated, it is given like the biases and has derivatives too; otherwise it
/// is one, at no cost.
class ImuMotion {
 public:
  using BiasJacobian = Eigen::Matrix<double, 9, 6>;
  using ScaleJacobian = Eigen::Matrix<double, 9, kImuScaleSize>;

  ImuMotion() = default;  ///< of zero duration
  ImuMotion(const Eigen::Vector3d& gyro_bias, const Eigen::Vector3d& accelerometer_bias)
      : gyro_bias_(gyro_bias), accelerometer_bias_(accelerometer_bias) {}
  ImuMotion(const Eigen::Vector3d& gyro_bias, const Eigen::Vector3d& accelerometer_bias,
            const ImuScale& scale)
      : scaled_(true),
        gyro_bias_(gyro_bias),
        accelerometer_bias_(accelerometer_bias),
        scale_(scale) {}

  /// Not checked: finite values, duration > 0.
  void integrate(const Eigen::Vector3d& angular_rate, const Eigen::Vector3d& specific_force,
                 double duration);

  /// The state after the motion from `start`, whose biases it keeps; corrected to first order for
  /// biases and a scale other than those integrated with, equation (44). `derivative`, when given,
  /// is that of the result by `start`; `by_scale`, of its first three parts by the scale, is set
  /// when `scaled()`.
  NavState propagate(const NavState& start, const ImuScale& scale, const Gravity& gravity,
                     StateMatrix* derivative = nullptr, ScaleJacobian* by_scale = nullptr) const;
  /// With the scale used in the integration.
  NavState propagate(const NavState& start, const Gravity& gravity,
                     StateMatrix* derivative = nullptr) const {
    return propagate(start, scale_, gravity, derivative);
  }
  /// Change of [position; rotation (right); velocity] for biases and scale that differ from those
  /// of the integration.
  [[nodiscard]] Eigen::Matrix<double, 9, 1> correction(const NavState& start,
                                                       const ImuScale& scale) const;

  [[nodiscard]] double duration() const noexcept { return duration_; }
  [[nodiscard]] const Eigen::Vector3d& position() const noexcept { return position_; }
  [[nodiscard]] const geometry::SO3& rotation() const noexcept { return rotation_; }
  [[nodiscard]] const Eigen::Vector3d& velocity() const noexcept { return velocity_; }
  [[nodiscard]] const Eigen::Vector3d& gyro_bias() const noexcept { return gyro_bias_; }
  [[nodiscard]] const Eigen::Vector3d& accelerometer_bias() const noexcept {
    return accelerometer_bias_;
  }
  /// Derivative of [position; rotation (right); velocity] with respect to [gyro bias; accelerometer
  /// bias].
  [[nodiscard]] const BiasJacobian& bias_jacobian() const noexcept { return bias_jacobian_; }
  /// Whether the scale is estimated; otherwise its derivatives are zero.
  [[nodiscard]] bool scaled() const noexcept { return scaled_; }
  [[nodiscard]] const ImuScale& scale() const noexcept { return scale_; }
  /// Derivative of the same with respect to the scale.
  [[nodiscard]] const ScaleJacobian& scale_jacobian() const noexcept { return scale_jacobian_; }

 private:
  bool scaled_ = false;
  double duration_ = 0;
  geometry::SO3 rotation_{};
  Eigen::Vector3d position_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d gyro_bias_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d accelerometer_bias_ = Eigen::Vector3d::Zero();
  ImuScale scale_{};
  BiasJacobian bias_jacobian_ = BiasJacobian::Zero();
  ScaleJacobian scale_jacobian_ = ScaleJacobian::Zero();
};

/// An ImuMotion with the covariance of [position; rotation; velocity; gyro bias; accelerometer
/// bias] at its end, in the order of a state, conditional on the state at its beginning.
class ImuPreintegration {
 public:
  /// `noise` is not checked.
  ImuPreintegration() = default;
  explicit ImuPreintegration(const ImuMotion& of_no_duration) : motion_(of_no_duration) {}
  ImuPreintegration(const Eigen::Vector3d& gyro_bias, const Eigen::Vector3d& accelerometer_bias)
      : motion_(gyro_bias, accelerometer_bias) {}

  /// Not checked: finite values, duration > 0, a valid noise.
  void integrate(const Eigen::Vector3d& angular_rate, const Eigen::Vector3d& specific_force,
                 double duration, const ImuNoise& noise);
  /// A random walk of the rotation about an axis along gravity, in the body at the end, which moves
  /// nothing else: `density` in rad/sqrt(s).
  void add_turn_noise(const Eigen::Vector3d& axis, double density, double duration);

  [[nodiscard]] const ImuMotion& motion() const noexcept { return motion_; }
  [[nodiscard]] const StateMatrix& covariance() const noexcept { return covariance_; }

 private:
  ImuMotion motion_;
  StateMatrix covariance_ = StateMatrix::Zero();
};

/// The factor between the states at both ends of a preintegration: equation (45), with the
/// differences of the biases below it, whitened. 15 rows in the order of a state.
class ImuFactor {
 public:
  static constexpr int kRows = kStateSize;
  using Residual = Eigen::Matrix<double, kRows, 1>;

  /// Throws std::invalid_argument when the covariance is not positive definite (no duration, NaN).
  ImuFactor(const ImuPreintegration& preintegration, const Gravity& gravity);

  /// Sets `from` and `to` of the derivatives, when given, and in `globals` those of the scale of
  /// the IMU, if it is estimated.
  Residual evaluate(const NavState& from, const NavState& to, const GlobalStates& globals,
                    Jacobians<kRows>* jacobians = nullptr) const;

  [[nodiscard]] const ImuMotion& motion() const noexcept { return motion_; }

 private:
  ImuMotion motion_;
  Gravity gravity_;
  StateMatrix square_root_information_;  // lower triangular
};

}  // namespace pipescout::estimation
