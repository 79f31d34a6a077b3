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
};

[[nodiscard]] InputFault check(const VisualPoseMeasurement& m) noexcept;
/// Its numbers but for covariance and times.
void add_values(const VisualPoseMeasurement& m, Fingerprint& fingerprint);

/// W [R_r^T (p + o v - p_r) - t; log(R_z^T R_r^T R exp(o w))], with p_r, R_r the pose of the rack,
/// o the time offset, w the angular rate.
class VisualPoseFactor : public MeasuredFactor<VisualPoseMeasurement, FactorKind::kVisualPose, 6> {
 public:
  explicit VisualPoseFactor(const VisualPoseMeasurement& measurement);
  Residual evaluate(const NavState& x, const GlobalStates& globals,
                    Derivatives* derivatives = nullptr) const;
};

}  // namespace pipescout::estimation
