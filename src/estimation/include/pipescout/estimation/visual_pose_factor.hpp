// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "pipescout/estimation/factor.hpp"

namespace pipescout::estimation {

/// Pose of the body in the rack frame.
struct VisualPoseMeasurement {
  using FactorType = class VisualPoseFactor;
  double time = 0;
  geometry::SE3 T_rack_body{};
  /// [translation, in the rack frame; rotation, in the body frame (right)]
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
  /// rad/s, of the body, as measured by the gyro; used with a time offset.
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();
  /// m, of the camera in the body, as `T_rack_body` has it; used with `mounting`.
  Eigen::Vector3d camera = Eigen::Vector3d::Zero();
  /// Where in GlobalStates::own six numbers begin that say how the camera is really mounted:
  /// [m, by which it is further along the axes of the body; rotation vector, rad, by which it is
  /// turned in the body]; negative: as `T_rack_body` has it. See
  /// FixedLagSmootherParameters::estimate_camera_mounting.
  int mounting = -1;
};
inline constexpr int kMountingSize = 6;

[[nodiscard]] InputFault check(const VisualPoseMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const VisualPoseMeasurement& m, Fingerprint& fingerprint);

/// How the camera would have to be moved in the body to be where `T_rack_body` has it: the body of
/// `T_rack_body` is the true one moved by it, T_rack_true * this.
[[nodiscard]] geometry::SE3 mounting_error(const VisualPoseMeasurement& m,
                                           const GlobalStates& globals);

/// W [R_r^T (p + o v - p_r) + R_b l - t; log(R_z^T R_b E)], with p_r, R_r the pose of the rack, o
/// the time offset, w the angular rate, R_b = R_r^T R exp(o w) and (E, l) the mounting error.
class VisualPoseFactor : public MeasuredFactor<VisualPoseMeasurement, FactorKind::kVisualPose, 6> {
 public:
  explicit VisualPoseFactor(const VisualPoseMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
