// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

#include "pipescout/estimation/state.hpp"

/// Forward automatic differentiation: numbers that carry their derivatives by the tangent vectors
/// of two states and of the globals, and just enough geometry over them to say a residual again.
namespace pipescout::estimation::test {

inline constexpr int kFromPlace = 0;
inline constexpr int kToPlace = kStateSize;
inline constexpr int kGlobalPlace = 2 * kStateSize;
inline constexpr int kVariables = kGlobalPlace + kGlobalSize;

struct Dual {
  double v = 0;
  Eigen::Matrix<double, kVariables, 1> d = Eigen::Matrix<double, kVariables, 1>::Zero();

  Dual() = default;
  Dual(double value) : v(value) {}  // NOLINT(google-explicit-constructor): a number is one too
  static Dual variable(double value, int place) {
    Dual x(value);
    x.d[place] = 1;
    return x;
  }
  static Dual of(double value, const Dual& x, double slope) {
    Dual y(value);
    y.d = slope * x.d;
    return y;
  }
};

inline Dual operator+(const Dual& a, const Dual& b) {
  Dual c(a.v + b.v);
  c.d = a.d + b.d;
  return c;
}
inline Dual operator-(const Dual& a) {
  return Dual::of(-a.v, a, -1);
}
inline Dual operator-(const Dual& a, const Dual& b) {
  return a + (-b);
}
inline Dual operator*(const Dual& a, const Dual& b) {
  Dual c(a.v * b.v);
  c.d = b.v * a.d + a.v * b.d;
  return c;
}
inline Dual operator/(const Dual& a, const Dual& b) {
  Dual c(a.v / b.v);
  c.d = (a.d - c.v * b.d) / b.v;
  return c;
}
inline Dual sqrt(const Dual& a) {
  return Dual::of(std::sqrt(a.v), a, 0.5 / std::sqrt(a.v));
}
inline Dual sin(const Dual& a) {
  return Dual::of(std::sin(a.v), a, std::cos(a.v));
}
inline Dual cos(const Dual& a) {
  return Dual::of(std::cos(a.v), a, -std::sin(a.v));
}
inline Dual atan2(const Dual& y, const Dual& x) {
  Dual c(std::atan2(y.v, x.v));
  c.d = (x.v * y.d - y.v * x.d) / (x.v * x.v + y.v * y.v);
  return c;
}

using Dual3 = std::array<Dual, 3>;
using Dual33 = std::array<Dual3, 3>;

inline Dual3 operator+(const Dual3& a, const Dual3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Dual3 operator-(const Dual3& a, const Dual3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Dual3 operator*(const Dual& s, const Dual3& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
inline Dual dot(const Dual3& a, const Dual3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Dual3 operator*(const Dual33& m, const Dual3& a) {
  return {dot(m[0], a), dot(m[1], a), dot(m[2], a)};
}
inline Dual33 transpose(const Dual33& m) {
  Dual33 t;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      t[i][j] = m[j][i];
    }
  }
  return t;
}
inline Dual33 operator*(const Dual33& a, const Dual33& b) {
  const Dual33 columns = transpose(b);
  Dual33 c;
  for (std::size_t j = 0; j < 3; ++j) {
    const Dual3 column = a * columns[j];
    for (std::size_t i = 0; i < 3; ++i) {
      c[i][j] = column[i];
    }
  }
  return c;
}
inline Dual33 operator+(const Dual33& a, const Dual33& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Dual33 operator*(const Dual& s, const Dual33& a) {
  return {s * a[0], s * a[1], s * a[2]};
}

inline Dual3 constant(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}
inline Dual33 constant(const Eigen::Matrix3d& m) {
  return {constant(Eigen::Vector3d(m.row(0))), constant(Eigen::Vector3d(m.row(1))),
          constant(Eigen::Vector3d(m.row(2)))};
}
inline Dual33 cross_matrix(const Dual3& v) {
  return {Dual3{0, -v[2], v[1]}, Dual3{v[2], 0, -v[0]}, Dual3{-v[1], v[0], 0}};
}
/// exp of a rotation vector other than 0 (Rodrigues).
inline Dual33 rotation(const Dual3& phi) {
  const Dual a = sqrt(dot(phi, phi));
  const Dual33 s = cross_matrix(phi);
  return constant(Eigen::Matrix3d(Eigen::Matrix3d::Identity())) + (sin(a) / a) * s +
         ((1 - cos(a)) / (a * a)) * (s * s);
}
/// exp, right to second order about 0.
inline Dual33 small_rotation(const Dual3& phi) {
  const Dual33 s = cross_matrix(phi);
  return constant(Eigen::Matrix3d(Eigen::Matrix3d::Identity())) + s + Dual(0.5) * (s * s);
}
/// Twice the sine of a rotation's angle times its axis.
inline Dual3 twice_sine(const Dual33& r) {
  return {r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]};
}
/// Angle of a rotation that is neither 0 nor pi. An arc cosine would lose digits near pi.
inline Dual angle_of(const Dual33& r) {
  const Dual3 s = twice_sine(r);
  return atan2(sqrt(dot(s, s)), r[0][0] + r[1][1] + r[2][2] - 1);
}
inline Dual3 log(const Dual33& r) {
  const Dual3 s = twice_sine(r);
  return (angle_of(r) / sqrt(dot(s, s))) * s;
}

inline Dual3 variables(const Eigen::Vector3d& v, int place) {
  return {Dual::variable(v[0], place), Dual::variable(v[1], place + 1),
          Dual::variable(v[2], place + 2)};
}

/// Row by row.
inline Dual33 rows_of_variables(const Eigen::Matrix3d& m, int place) {
  return {variables(Eigen::Vector3d(m.row(0)), place),
          variables(Eigen::Vector3d(m.row(1)), place + 3),
          variables(Eigen::Vector3d(m.row(2)), place + 6)};
}

struct DualState {
  Dual33 r;
  Dual3 p, v, gyro_bias, accelerometer_bias;

  DualState(const NavState& x, int place)
      : r(constant(x.R_map_body.matrix()) *
          small_rotation(variables(Eigen::Vector3d::Zero(), place + kRotation))),
        p(variables(x.position, place + kPosition)),
        v(variables(x.velocity, place + kVelocity)),
        gyro_bias(variables(x.gyro_bias, place + kGyroBias)),
        accelerometer_bias(variables(x.accelerometer_bias, place + kAccelerometerBias)) {}
};

struct DualGlobals {
  Dual scale, yaw, pitch;
  Dual3 rack_position;
  Dual33 rack_rotation;
  Dual3 lever;
  Dual time_offset;
  Dual visual_time_offset;
  Dual33 gyro_scale;
  Dual33 accelerometer_scale;

  explicit DualGlobals(const GlobalStates& g)
      : scale(Dual::variable(g.odometer_scale, kGlobalPlace + kOdometerScale)),
        yaw(Dual::variable(g.mount_yaw, kGlobalPlace + kMountYaw)),
        pitch(Dual::variable(g.mount_pitch, kGlobalPlace + kMountPitch)),
        rack_position(variables(g.rack_position, kGlobalPlace + kRackPosition)),
        rack_rotation(
            constant(g.R_map_rack.matrix()) *
            small_rotation(variables(Eigen::Vector3d::Zero(), kGlobalPlace + kRackRotation))),
        lever(variables(g.gps_lever_arm, kGlobalPlace + kGpsLeverArm)),
        time_offset(Dual::variable(g.gps_time_offset, kGlobalPlace + kGpsTimeOffset)),
        visual_time_offset(
            Dual::variable(g.visual_pose_time_offset, kGlobalPlace + kVisualPoseTimeOffset)),
        gyro_scale(rows_of_variables(g.imu_scale.gyro, kGlobalPlace + kImuScale)),
        accelerometer_scale(
            rows_of_variables(g.imu_scale.accelerometer, kGlobalPlace + kImuScale + 9)) {}

  /// From the body to a frame whose x axis is the direction of travel.
  [[nodiscard]] Dual33 travel() const {
    const Dual cy = cos(yaw);
    const Dual sy = sin(yaw);
    const Dual cp = cos(pitch);
    const Dual sp = sin(pitch);
    const Dual33 rz = {Dual3{cy, -sy, 0}, Dual3{sy, cy, 0}, Dual3{0, 0, 1}};
    const Dual33 ry = {Dual3{cp, 0, sp}, Dual3{0, 1, 0}, Dual3{-sp, 0, cp}};
    return transpose(rz * ry);
  }
};

}  // namespace pipescout::estimation::test
