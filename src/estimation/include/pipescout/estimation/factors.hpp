// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string_view>
#include <variant>

#include "pipescout/estimation/state.hpp"

/// Measurements and their factors. SI units, radians; times in seconds of any one clock. Frames as
/// in state.hpp.
///
/// A factor is a value of fixed size. Its `evaluate` returns the whitened residual, which has unit
/// covariance if the covariance of the measurement is right, and its whitened derivatives.
/// Derivatives that are given as an argument must be zero and are set where they are not. All are
/// pure.
namespace pipescout::estimation {

enum class FactorKind : std::uint8_t {
  kImu,
  kPrior,
  kGps,
  kHeading,
  kVisualPose,
  kWeld,
  kNonHolonomic,
  kZeroVelocity,
  kOdometer,
  kRelativePose,
  kZeroAngularRate,
  kCentreLine,
};
inline constexpr std::size_t kFactorKinds = 12;

/// "imu", "prior", "gps", "heading", "visual_pose", "weld", "non_holonomic", "zero_velocity",
/// "odometer", "relative_pose", "zero_angular_rate", "centre_line"; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(FactorKind kind) noexcept;

/// Faults of a measurement's values.
enum class InputFault : std::uint8_t {
  kNone,
  kNotFinite,      ///< a NaN or infinity
  kBadCovariance,  ///< a standard deviation outside [1e-9, 1e9], or a covariance that is not
                   ///< symmetric and positive definite
  kBadInterval,    ///< `to_time` is not after `from_time`
  kBadDirection,   ///< its norm differs from 1 by more than 1e-6
};

/// Antenna position. Lever arm and time offset are in `GlobalStates`.
struct GpsMeasurement {
  double time = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m, in the map
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// rad/s, in the body, at that time; 0 if unknown. It moves the antenna only during the time
  /// offset, so that the gyro bias is negligible.
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();
};

/// Angle of the body's x axis about the map's z axis, from the map's x axis.
struct HeadingMeasurement {
  double time = 0;
  double heading = 0;
  double standard_deviation = 0;
};

/// Pose of the body in the rack frame.
struct VisualPoseMeasurement {
  double time = 0;
  geometry::SE3 T_rack_body{};
  /// [translation, in the rack frame; rotation, in the body frame (right)]
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
};

/// Passage of a weld at a known position. Created by `PipeCentreLine::weld`, or by hand.
struct WeldMeasurement {
  double time = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< m, of the weld in the map
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< unit, of the pipe there, in the map
  double along_deviation = 0;                            ///< m, along the pipe
  double across_deviation = 0;                           ///< m, across it
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();      ///< m, of the weld sensor in the body
};

/// The body is in a pipe whose centre line passes through `position`; the position along it is not
/// constrained.
struct CentreLineMeasurement {
  double time = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< m, in the map
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< unit, of the line there, in the map
  double standard_deviation = 0;  ///< m, of the body from the line, per axis across it
};

/// A point of the body, its wheels' or tracks', moves along the direction of travel
/// (`GlobalStates::mount_yaw`, `mount_pitch`) only.
struct NonHolonomicMeasurement {
  double time = 0;
  double lateral_deviation = 0;                            ///< m/s
  double vertical_deviation = 0;                           ///< m/s
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();        ///< m, of the point in the body
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  ///< rad/s, as measured by the gyro; used
                                                           ///< if the point is not the origin
};

/// Standstill of the body.
struct ZeroVelocityMeasurement {
  double time = 0;
  double standard_deviation = 0;  ///< m/s, per axis
};

/// The body does not rotate.
struct ZeroAngularRateMeasurement {
  double time = 0;
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  ///< rad/s, as measured by the gyro
  double standard_deviation = 0;                           ///< rad/s, per axis
};

/// Distance that a point of the body, the wheel, has travelled along the direction of travel,
/// forwards positive, on an arc.
struct OdometerMeasurement {
  double from_time = 0;
  double to_time = 0;
  double distance = 0;            ///< m, before the scale
  double standard_deviation = 0;  ///< m
  /// m, standard deviation of the lateral and vertical slip of the point
  double across_deviation = 0;
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();  ///< m, of the point in the body
};

/// Motion of the body between two times.
struct RelativePoseMeasurement {
  double from_time = 0;
  double to_time = 0;
  geometry::SE3 T_from_to{};
  /// [translation; rotation], both in the body frame at `to_time` (right)
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
};

[[nodiscard]] InputFault check(const GpsMeasurement& m) noexcept;
[[nodiscard]] InputFault check(const HeadingMeasurement& m) noexcept;
[[nodiscard]] InputFault check(const VisualPoseMeasurement& m) noexcept;
[[nodiscard]] InputFault check(const WeldMeasurement& m) noexcept;
[[nodiscard]] InputFault check(const CentreLineMeasurement& m) noexcept;
[[nodiscard]] InputFault check(const NonHolonomicMeasurement& m) noexcept;
[[nodiscard]] InputFault check(const ZeroVelocityMeasurement& m) noexcept;
[[nodiscard]] InputFault check(const ZeroAngularRateMeasurement& m) noexcept;
[[nodiscard]] InputFault check(const OdometerMeasurement& m) noexcept;
[[nodiscard]] InputFault check(const RelativePoseMeasurement& m) noexcept;

/// A factor of `Rows` rows from a measurement without faults according to `check`, which is a
/// precondition. The derived classes differ in `evaluate` only.
template <class Measurement, FactorKind Kind, int Rows>
class MeasuredFactor {
 public:
  using MeasurementType = Measurement;
  static constexpr FactorKind kKind = Kind;
  static constexpr int kRows = Rows;
  /// Whether it connects the states at two times, `from_time` and `to_time`.
  static constexpr bool kRelative =
      Kind == FactorKind::kOdometer || Kind == FactorKind::kRelativePose;
  using Residual = Eigen::Matrix<double, Rows, 1>;
  using Derivatives = Jacobians<Rows>;

  explicit MeasuredFactor(const Measurement& measurement) : measurement_(measurement) {}
  [[nodiscard]] const Measurement& measurement() const noexcept { return measurement_; }

 protected:
  Measurement measurement_;
  /// W with W^T W the inverse of the covariance.
  Eigen::Matrix<double, Rows, Rows, Eigen::DontAlign> whitening_;
};

/// W (p + t v + R (l + t w x l) - z), with l the lever arm, t the time offset and w the angular
/// rate.
class GpsFactor : public MeasuredFactor<GpsMeasurement, FactorKind::kGps, 3> {
 public:
  explicit GpsFactor(const GpsMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

/// (atan2(e_y, e_x) - z) / sigma in (-pi, pi] / sigma, e = R [1 0 0]^T. NaN, with its derivatives,
/// where the body's x axis is within 1e-3 rad of the vertical.
class HeadingFactor : public MeasuredFactor<HeadingMeasurement, FactorKind::kHeading, 1> {
 public:
  explicit HeadingFactor(const HeadingMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

/// W [R_r^T (p - p_r) - t; log(R_z^T R_r^T R)], with p_r, R_r the pose of the rack.
class VisualPoseFactor : public MeasuredFactor<VisualPoseMeasurement, FactorKind::kVisualPose, 6> {
 public:
  explicit VisualPoseFactor(const VisualPoseMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

/// W (p + R l - z), with different standard deviations across the pipe and along it.
class WeldFactor : public MeasuredFactor<WeldMeasurement, FactorKind::kWeld, 3> {
 public:
  explicit WeldFactor(const WeldMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

/// W A (p - z); the rows of A are of length 1, across the line and across each other.
class CentreLineFactor : public MeasuredFactor<CentreLineMeasurement, FactorKind::kCentreLine, 2> {
 public:
  explicit CentreLineFactor(const CentreLineMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;

 private:
  Eigen::Matrix<double, 2, 3, Eigen::DontAlign> across_;
};

/// W (M^T (R^T v + (w - b) x s)) without its first row; M = Rz(mount yaw) Ry(mount pitch), s the
/// point, w the angular rate and b the bias of the gyro.
class NonHolonomicFactor
    : public MeasuredFactor<NonHolonomicMeasurement, FactorKind::kNonHolonomic, 2> {
 public:
  explicit NonHolonomicFactor(const NonHolonomicMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

/// v / sigma
class ZeroVelocityFactor
    : public MeasuredFactor<ZeroVelocityMeasurement, FactorKind::kZeroVelocity, 3> {
 public:
  explicit ZeroVelocityFactor(const ZeroVelocityMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

/// (w - b) / sigma, b the bias of the gyro
class ZeroAngularRateFactor
    : public MeasuredFactor<ZeroAngularRateMeasurement, FactorKind::kZeroAngularRate, 3> {
 public:
  explicit ZeroAngularRateFactor(const ZeroAngularRateMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

/// W (K M^T (R_i + R_j)^T (q_j - q_i) / 2 - [d sin(a) / a; 0; 0]), with q = p + R s the position of
/// the point in the map, K = diag(1/k, 1, 1), k the scale, d the distance and a the angle of R_i^T
/// R_j: exact for an arc of a circle whose axis is across the travel. The scale multiplies the
/// states and not d: if it multiplied the noise of d, the minimum of the cost would be biased
/// towards small scales. Not finite for a scale of 0.
class OdometerFactor : public MeasuredFactor<OdometerMeasurement, FactorKind::kOdometer, 3> {
 public:
  explicit OdometerFactor(const OdometerMeasurement& measurement);
  Residual evaluate(const NavState& from, const NavState& to, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

/// W [R_z^T (R_i^T (p_j - p_i) - t); log(R_z^T R_i^T R_j)]
class RelativePoseFactor
    : public MeasuredFactor<RelativePoseMeasurement, FactorKind::kRelativePose, 6> {
 public:
  explicit RelativePoseFactor(const RelativePoseMeasurement& measurement);
  Residual evaluate(const NavState& from, const NavState& to, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

/// Prior of a state: W local(mean, x).
class PriorFactor {
 public:
  static constexpr FactorKind kKind = FactorKind::kPrior;
  static constexpr int kRows = kStateSize;
  using Residual = StateVector;

  /// `covariance` over the tangent space at `mean`. Throws std::invalid_argument when the mean is
  /// not finite or the covariance is not that of standard deviations in [1e-9, 1e9].
  PriorFactor(const NavState& mean, const StateMatrix& covariance);
  Residual evaluate(const NavState& x, Jacobians<kRows>* derivatives = nullptr) const;

 private:
  NavState mean_;
  StateMatrix whitening_;
};

/// Any factor from a measurement.
using AnyFactor = std::variant<GpsFactor, HeadingFactor, VisualPoseFactor, WeldFactor,
                               NonHolonomicFactor, ZeroVelocityFactor, OdometerFactor,
                               RelativePoseFactor, ZeroAngularRateFactor, CentreLineFactor>;

}  // namespace pipescout::estimation
