// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/start_alignment.hpp"

#include <cmath>
#include <numbers>

#include "pipescout/linear_algebra/cholesky.hpp"

namespace pipescout::estimation {
namespace {

constexpr double kLeastDrift = 1e-6;       // m/s, in place of none
constexpr double kUnknownRotation = 1e-6;  // information that keeps c and s of a point regular

}  // namespace

std::optional<geometry::SO3> level(const Eigen::Vector3d& specific_force) noexcept {
  constexpr double kLeastForce = 1e-3;
  if (!(specific_force.allFinite() && specific_force.norm() >= kLeastForce)) {
    return std::nullopt;
  }
  const Eigen::Vector3d up = specific_force.normalized();
  return geometry::SO3::from_roll_pitch_yaw(
      {std::atan2(up.y(), up.z()), std::atan2(-up.x(), std::hypot(up.y(), up.z())), 0});
}

void TrackAlignment::add(double time, const Eigen::Vector3d& measured,
                         const Eigen::Vector3d& reckoned, double deviation) noexcept {
  if (pairs_ == 0) {
    first_time_ = time;
    first_measured_ = measured;
    first_reckoned_ = reckoned;
    low_ = high_ = reckoned.head<2>();
  }
  ++pairs_;
  newest_time_ = time;
  newest_reckoned_ = reckoned;
  low_ = low_.cwiseMin(reckoned.head<2>());
  high_ = high_.cwiseMax(reckoned.head<2>());
  const double elapsed = time - first_time_;
  const Eigen::Vector3d m = (measured - first_measured_) / deviation;
  const Eigen::Vector3d r = (reckoned - first_reckoned_) / deviation;
  const double w = 1 / deviation;
  Eigen::Matrix<double, 2, 6> rows;
  rows << r.x(), -r.y(), w, 0, w * elapsed, 0,  //
      r.y(), r.x(), 0, w, 0, w * elapsed;
  information_.noalias() += rows.transpose() * rows;
  vector_.noalias() += rows.transpose() * m.head<2>();
  sum_ += m.head<2>().squaredNorm();
  const Eigen::Vector2d row(w, w * elapsed);
  height_information_.noalias() += row * row.transpose();
  height_vector_ += row * (m.z() - r.z());
}

double TrackAlignment::extent() const noexcept {
  return (high_ - low_).norm();
}

double TrackAlignment::drift_information() const noexcept {
  const double deviation = std::max(drift_deviation_, kLeastDrift);
  return 1 / (deviation * deviation);
}

TrackAlignment::Result TrackAlignment::at_newest(const Vector6& x, double yaw) const noexcept {
  const double elapsed = newest_time_ - first_time_;
  const Eigen::Vector3d r = newest_reckoned_ - first_reckoned_;
  Eigen::Matrix2d heights = height_information_;
  heights(1, 1) += drift_information();
  const Eigen::Vector2d height = linear_algebra::Cholesky<2>(heights).solve(height_vector_);
  const Eigen::Vector3d newest =
      first_measured_ + Eigen::Vector3d(x[0] * r.x() - x[1] * r.y() + x[2] + x[4] * elapsed,
                                        x[1] * r.x() + x[0] * r.y() + x[3] + x[5] * elapsed,
                                        r.z() + height[0] + height[1] * elapsed);
  return {.yaw = yaw,
          .offset = newest - geometry::SO3::about_z(yaw) * newest_reckoned_,
          .drift = {x[4], x[5], height[1]}};
}

std::optional<TrackAlignment::Result> TrackAlignment::solve() const noexcept {
  constexpr std::size_t kLeastPairs = 3;
  if (pairs_ < kLeastPairs) {
    return std::nullopt;
  }
  Matrix6 a = information_;
  a.diagonal().head<2>().array() += kUnknownRotation;
  a.diagonal().tail<2>().array() += drift_information();
  const linear_algebra::Cholesky<6> root(a);
  const Vector6 x = root.solve(vector_);
  const double scale = std::hypot(x[0], x[1]);
  if (!root.succeeded() || !x.allFinite()) {
    return std::nullopt;
  }
  const double yaw = std::atan2(x[1], x[0]);
  Result result = at_newest(x, yaw);
  const Matrix6 covariance = root.inverse();
  const Eigen::Vector2d along(std::cos(yaw), std::sin(yaw));
  const Eigen::Vector2d across(-along.y(), along.x());
  const Eigen::Matrix2d rotation = covariance.topLeftCorner<2, 2>();
  result.scale = scale;
  result.scale_deviation = std::hypot(std::sqrt(along.dot(rotation * along)), reckoning_share_);
  const double turned = std::sqrt(across.dot(rotation * across)) / std::max(scale, 1e-9);
  result.yaw_deviation = std::min(std::hypot(turned, reckoning_share_), std::numbers::pi);
  const Eigen::Vector3d r = newest_reckoned_ - first_reckoned_;
  const double elapsed = newest_time_ - first_time_;
  Eigen::Matrix<double, 2, 6> newest;
  newest << r.x(), -r.y(), 1, 0, elapsed, 0, r.y(), r.x(), 0, 1, 0, elapsed;
  const Eigen::Matrix2d place = newest * covariance * newest.transpose();
  result.offset_deviation =
      std::hypot(std::sqrt(place.diagonal().maxCoeff()), reckoning_share_ * extent());
  result.drift_deviation = std::sqrt(covariance.diagonal().tail<2>().maxCoeff());
  result.chi_square = std::max(sum_ - vector_.dot(x), 0.0);
  result.degrees = 2 * static_cast<int>(pairs_) - 4;
  return result;
}

std::optional<TrackAlignment::Result> TrackAlignment::solve(double yaw) const noexcept {
  if (pairs_ == 0) {
    return std::nullopt;
  }
  Matrix6 a = information_;
  a.diagonal().tail<2>().array() += drift_information();
  const Eigen::Vector2d turn(std::cos(yaw), std::sin(yaw));
  const linear_algebra::Cholesky<4> root(a.bottomRightCorner<4, 4>());
  Vector6 x;
  x << turn, root.solve(vector_.tail<4>() - a.bottomLeftCorner<4, 2>() * turn);
  if (!root.succeeded() || !x.allFinite()) {
    return std::nullopt;
  }
  Result result = at_newest(x, yaw);
  const double elapsed = newest_time_ - first_time_;
  Eigen::Matrix<double, 2, 4> newest;
  newest << 1, 0, elapsed, 0, 0, 1, 0, elapsed;
  const Eigen::Matrix4d covariance = root.inverse();
  const Eigen::Matrix2d place = newest * covariance * newest.transpose();
  result.drift_deviation = std::sqrt(covariance.diagonal().tail<2>().maxCoeff());
  result.offset_deviation =
      std::hypot(std::sqrt(place.diagonal().maxCoeff()), reckoning_share_ * extent());
  result.chi_square = std::max(sum_ - 2 * vector_.dot(x) + x.dot(a * x), 0.0);
  result.degrees = 2 * static_cast<int>(pairs_) - 2;
  return result;
}

}  // namespace pipescout::estimation
