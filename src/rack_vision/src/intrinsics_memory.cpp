// SPDX-License-Identifier: Apache-2.0
#include "intrinsics_memory.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "pipescout/linear_algebra/cholesky.hpp"
#include "pipescout/linear_algebra/symmetric_eigen.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr double kAlikeImages = 20;
constexpr double kDrift = 0.02;       // px/sqrt(s)
constexpr double kCredible = 4;       // standard deviations of the calibration
constexpr double kWorthwhile = 0.25;  // px, at the corners of the image

Eigen::Vector3d intrinsics_of(const geometry::CameraParameters& camera) {
  return {camera.focal_length, camera.centre_u, camera.centre_v};
}

}  // namespace

IntrinsicsMemory::IntrinsicsMemory(const geometry::Camera& calibrated, double focal_sigma,
                                   double centre_sigma)
    : calibrated_(calibrated.parameters()), sigma_(focal_sigma, centre_sigma, centre_sigma) {
  reset();
}

void IntrinsicsMemory::reset() {
  in_use_ = intrinsics_of(calibrated_);
  belief_ = {in_use_, Eigen::Matrix3d(sigma_.cwiseAbs2().asDiagonal())};
}

void IntrinsicsMemory::predict(double dt) {
  belief_.covariance.diagonal().array() += kDrift * kDrift * dt;
}

void IntrinsicsMemory::learn(const IntrinsicsBelief& after) {
  // In units in which the belief is the unit matrix, along the directions in which the image's word
  // is independent: there it has information w, and moved the mean by w / (1 + w) of what it would.
  const linear_algebra::Cholesky<3> factors(belief_.covariance);
  const Eigen::Matrix3d unit = factors.lower();
  const Eigen::Matrix3d posterior =
      unit.transpose() * linear_algebra::Cholesky<3>(after.covariance).inverse() * unit;
  const auto eigen = linear_algebra::symmetric_eigen(posterior);
  if (!factors.succeeded() || !eigen.succeeded) {
    return;
  }
  Eigen::Vector3d move = eigen.vectors.transpose() * factors.whiten(after.mean - belief_.mean);
  Eigen::Vector3d variance;
  for (int i = 0; i < 3; ++i) {
    // Residuals that fit badly may leave less than nothing.
    const double said = std::max(0.0, eigen.values(i) - 1);
    move(i) *= said > 0 ? (1 + said) / (kAlikeImages + said) : 0;
    variance(i) = kAlikeImages / (kAlikeImages + said);
  }
  const Eigen::Matrix3d axes = unit * eigen.vectors;
  const Eigen::Vector3d mean = belief_.mean + axes * move;
  const Eigen::Vector3d left = (mean - intrinsics_of(calibrated_)).cwiseQuotient(sigma_);
  if (variance.allFinite() && left.cwiseAbs().maxCoeff() < kCredible) {
    belief_ = {mean, axes * variance.asDiagonal() * axes.transpose()};
  }
}

std::optional<geometry::Camera> IntrinsicsMemory::improved() {
  const Eigen::Vector3d moved = belief_.mean - in_use_;
  const double to_corner = 0.5 * std::hypot(calibrated_.width, calibrated_.height);
  if (std::abs(moved(0)) * to_corner / in_use_(0) + moved.tail<2>().norm() < kWorthwhile) {
    return std::nullopt;
  }
  geometry::CameraParameters parameters = calibrated_;
  parameters.focal_length = belief_.mean(0);
  parameters.centre_u = belief_.mean(1);
  parameters.centre_v = belief_.mean(2);
  try {
    const geometry::Camera camera(parameters);
    in_use_ = belief_.mean;
    return camera;
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // its distortion could not be inverted
  }
}

}  // namespace pipescout::rack_vision
