// SPDX-License-Identifier: Apache-2.0
// Factors of one time.
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "direction_of_travel.hpp"
#include "pipescout/estimation/factors.hpp"
#include "pipescout/linear_algebra/products.hpp"
#include "square_root_information.hpp"

namespace pipescout::estimation {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::skew;
using geometry::SO3;

GpsFactor::GpsFactor(const GpsMeasurement& measurement) : MeasuredFactor(measurement) {
  whitening_ = whitening_of(measurement.covariance);
}

GpsFactor::Residual GpsFactor::evaluate(const NavState& x, const GlobalStates& globals,
                                        Derivatives* derivatives) const {
  const double offset = globals.gps_time_offset;
  const Vector3d swing = measurement_.angular_rate.cross(globals.gps_lever_arm);
  const Vector3d lever = globals.gps_lever_arm + offset * swing;
  if (derivatives != nullptr) {
    const Matrix3d turned = whitening_ * x.R_map_body.matrix();
    derivatives->from.middleCols<3>(kPosition) = whitening_;
    derivatives->from.middleCols<3>(kRotation) = -turned * skew(lever);
    derivatives->from.middleCols<3>(kVelocity) = offset * whitening_;
    derivatives->globals.middleCols<3>(kGpsLeverArm) =
        turned + offset * turned * skew(measurement_.angular_rate);
    derivatives->globals.col(kGpsTimeOffset) = whitening_ * (x.velocity + x.R_map_body * swing);
  }
  return whitening_ *
         (x.position + offset * x.velocity + x.R_map_body * lever - measurement_.position);
}

HeadingFactor::HeadingFactor(const HeadingMeasurement& measurement) : MeasuredFactor(measurement) {
  whitening_(0, 0) = 1 / measurement.standard_deviation;
}

HeadingFactor::Residual HeadingFactor::evaluate(const NavState& x, const GlobalStates& /*globals*/,
                                                Derivatives* derivatives) const {
  constexpr double kVertical = 1e-3;
  const Matrix3d r = x.R_map_body.matrix();
  const Vector3d forward = r.col(0);
  const double square = forward.head<2>().squaredNorm();
  const bool defined = square >= kVertical * kVertical;
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  if (derivatives != nullptr) {
    // d forward = R (d x e_1) = d_z (second column) - d_y (third column)
    const auto by = [&](const Vector3d& change) {
      return defined ? (forward.x() * change.y() - forward.y() * change.x()) / square : nothing;
    };
    derivatives->from(0, kRotation + 1) = -whitening_(0, 0) * by(r.col(2));
    derivatives->from(0, kRotation + 2) = whitening_(0, 0) * by(r.col(1));
  }
  const double heading = std::atan2(forward.y(), forward.x());
  const double error = std::remainder(heading - measurement_.heading, 2 * std::numbers::pi);
  return Residual(defined ? whitening_(0, 0) * error : nothing);
}

VisualPoseFactor::VisualPoseFactor(const VisualPoseMeasurement& measurement)
    : MeasuredFactor(measurement) {
  whitening_ = whitening_of(measurement.covariance);
}

VisualPoseFactor::Residual VisualPoseFactor::evaluate(const NavState& x,
                                                      const GlobalStates& globals,
                                                      Derivatives* derivatives) const {
  const SO3 R_rack_map = globals.R_map_rack.inverse();
  const Vector3d in_rack = R_rack_map * (x.position - globals.rack_position);
  const SO3 R_rack_body = R_rack_map * x.R_map_body;
  const Vector3d angle = (measurement_.T_rack_body.rotation().inverse() * R_rack_body).log();
  Residual r;
  r << in_rack - measurement_.T_rack_body.translation(), angle;
  if (derivatives != nullptr) {
    const Matrix3d to_rack = R_rack_map.matrix();
    const Matrix3d inverse = SO3::right_jacobian_inverse(angle);
    const auto by_translation = whitening_.leftCols<3>();
    const auto by_angle = whitening_.rightCols<3>();
    derivatives->from.middleCols<3>(kPosition) = by_translation * to_rack;
    derivatives->from.middleCols<3>(kRotation) = by_angle * inverse;
    derivatives->globals.middleCols<3>(kRackPosition) = -by_translation * to_rack;
    derivatives->globals.middleCols<3>(kRackRotation) =
        by_translation * skew(in_rack) - by_angle * inverse * R_rack_body.inverse().matrix();
  }
  return whitening_ * r;
}

WeldFactor::WeldFactor(const WeldMeasurement& measurement) : MeasuredFactor(measurement) {
  const Matrix3d along = measurement.direction * measurement.direction.transpose();
  whitening_ = along / measurement.along_deviation +
               (Matrix3d::Identity() - along) / measurement.across_deviation;
}

WeldFactor::Residual WeldFactor::evaluate(const NavState& x, const GlobalStates& /*globals*/,
                                          Derivatives* derivatives) const {
  if (derivatives != nullptr) {
    derivatives->from.middleCols<3>(kPosition) = whitening_;
    derivatives->from.middleCols<3>(kRotation) =
        -whitening_ * x.R_map_body.matrix() * skew(measurement_.sensor);
  }
  return whitening_ * (x.position + x.R_map_body * measurement_.sensor - measurement_.position);
}

CentreLineFactor::CentreLineFactor(const CentreLineMeasurement& measurement)
    : MeasuredFactor(measurement) {
  whitening_ = Eigen::Matrix2d::Identity() / measurement.standard_deviation;
  across_.row(0) = measurement.direction.unitOrthogonal().transpose();
  across_.row(1) = measurement.direction.cross(Vector3d(across_.row(0))).transpose();
}

CentreLineFactor::Residual CentreLineFactor::evaluate(const NavState& x,
                                                      const GlobalStates& /*globals*/,
                                                      Derivatives* derivatives) const {
  if (derivatives != nullptr) {
    derivatives->from.middleCols<3>(kPosition) = whitening_ * across_;
  }
  return whitening_ * across_ * (x.position - measurement_.position);
}

NonHolonomicFactor::NonHolonomicFactor(const NonHolonomicMeasurement& measurement)
    : MeasuredFactor(measurement) {
  whitening_ << 1 / measurement.lateral_deviation, 0, 0, 1 / measurement.vertical_deviation;
}

NonHolonomicFactor::Residual NonHolonomicFactor::evaluate(const NavState& x,
                                                          const GlobalStates& globals,
                                                          Derivatives* derivatives) const {
  const DirectionOfTravel travel(globals);
  const Vector3d origin = x.R_map_body.inverse() * x.velocity;
  const Vector3d unscaled = measurement_.angular_rate - x.gyro_bias;
  const Matrix3d& scale = globals.imu_scale.gyro;
  const Vector3d in_body = origin + (scale * unscaled).cross(measurement_.sensor);
  if (derivatives != nullptr) {
    const auto across = [&](const Matrix3d& m) { return (whitening_ * m.bottomRows<2>()).eval(); };
    derivatives->from.middleCols<3>(kRotation) = across(travel.R_travel_body * skew(origin));
    derivatives->from.middleCols<3>(kVelocity) =
        across(travel.R_travel_body * x.R_map_body.matrix().transpose());
    derivatives->from.middleCols<3>(kGyroBias) =
        across(travel.R_travel_body * skew(measurement_.sensor) * scale);
    derivatives->globals.col(kMountYaw) = whitening_ * (travel.by_yaw * in_body).tail<2>();
    derivatives->globals.col(kMountPitch) = whitening_ * (travel.by_pitch * in_body).tail<2>();
    const Eigen::Matrix<double, 2, 3> by_rate =
        across(-travel.R_travel_body * skew(measurement_.sensor));
    for (int row = 0; row < 3; ++row) {
      derivatives->globals.middleCols<3>(kImuScale + 3 * row) =
          by_rate.col(row) * unscaled.transpose();
    }
  }
  return whitening_ * (travel.R_travel_body * in_body).tail<2>();
}

ZeroVelocityFactor::ZeroVelocityFactor(const ZeroVelocityMeasurement& measurement)
    : MeasuredFactor(measurement) {
  whitening_ = Matrix3d::Identity() / measurement.standard_deviation;
}

ZeroVelocityFactor::Residual ZeroVelocityFactor::evaluate(const NavState& x,
                                                          const GlobalStates& /*globals*/,
                                                          Derivatives* derivatives) const {
  if (derivatives != nullptr) {
    derivatives->from.middleCols<3>(kVelocity) = whitening_;
  }
  return whitening_ * x.velocity;
}

ZeroAngularRateFactor::ZeroAngularRateFactor(const ZeroAngularRateMeasurement& measurement)
    : MeasuredFactor(measurement) {
  whitening_ = Matrix3d::Identity() / measurement.standard_deviation;
}

ZeroAngularRateFactor::Residual ZeroAngularRateFactor::evaluate(const NavState& x,
                                                                const GlobalStates& /*globals*/,
                                                                Derivatives* derivatives) const {
  if (derivatives != nullptr) {
    derivatives->from.middleCols<3>(kGyroBias) = -whitening_;
  }
  return whitening_ * (measurement_.angular_rate - x.gyro_bias);
}

PriorFactor::PriorFactor(const NavState& mean, const StateMatrix& covariance) : mean_(mean) {
  if (!mean.is_finite()) {
    throw std::invalid_argument("PriorFactor: the mean is not finite");
  }
  if (!is_covariance(covariance)) {
    throw std::invalid_argument(
        "PriorFactor: the covariance is not symmetric and positive definite with standard "
        "deviations in [1e-9, 1e9]");
  }
  whitening_ = whitening_of(covariance);
}

PriorFactor::Residual PriorFactor::evaluate(const NavState& x,
                                            Jacobians<kRows>* derivatives) const {
  const Residual r = mean_.local(x);
  if (derivatives != nullptr) {
    StateMatrix d = StateMatrix::Identity();
    d.block<3, 3>(kRotation, kRotation) = SO3::right_jacobian_inverse(r.segment<3>(kRotation));
    derivatives->from = linear_algebra::product(whitening_, d);
  }
  return whitening_ * r;
}

}  // namespace pipescout::estimation
