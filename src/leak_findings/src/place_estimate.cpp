// SPDX-License-Identifier: Apache-2.0
#include "place_estimate.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace pipescout::leak_findings {
namespace {

Eigen::Matrix3d inverse(const Eigen::Matrix3d& m) {
  return m.ldlt().solve(Eigen::Matrix3d::Identity());
}

}  // namespace

void PlaceEstimate::begin(const Bearing& bearing, const RangePrior& prior) {
  clear();
  origin_ = bearing.eye;
  information_ = prior.information;
  weighted_ = prior.information * (prior.point - origin_);
  first_time_ = bearing.time;
  // The rows of the first bearing need its range, which the prior tells.
  const Eigen::Vector3d across = bearing.ray.cross(bearing.along);
  add_row(bearing.along, 0,
          std::hypot(prior.range * bearing.along_deviation, bearing.position_jitter));
  add_row(across, 0, std::hypot(prior.range * bearing.across_deviation, bearing.position_jitter));
  bearings_ = 1;
  last_time_ = bearing.time;
  eye_sum_ = bearing.eye;
  base_sum_ = bearing.base;
  pose_covariance_sum_ = bearing.pose_covariance;
}

void PlaceEstimate::add(const Bearing& bearing) {
  const double range = (point() - bearing.eye).norm();
  const Eigen::Vector3d across = bearing.ray.cross(bearing.along);
  const Eigen::Vector3d eye = bearing.eye - origin_;
  add_row(bearing.along, bearing.along.dot(eye),
          std::hypot(range * bearing.along_deviation, bearing.position_jitter));
  add_row(across, across.dot(eye),
          std::hypot(range * bearing.across_deviation, bearing.position_jitter));
  ++bearings_;
  last_time_ = bearing.time;
  eye_sum_ += bearing.eye;
  base_sum_ += bearing.base;
  pose_covariance_sum_ += bearing.pose_covariance;
}

void PlaceEstimate::add_row(const Eigen::Vector3d& row, double value, double deviation) {
  const double weight = 1 / (deviation * deviation);
  information_ += weight * row * row.transpose();
  weighted_ += weight * value * row;
}

Eigen::Vector3d PlaceEstimate::point() const {
  return origin_ + information_.ldlt().solve(weighted_);
}

Eigen::Matrix3d PlaceEstimate::relative_covariance() const {
  return inverse(information_);
}

Eigen::Matrix3d PlaceEstimate::common_covariance(const Eigen::Vector3d& near,
                                                 double correlation_time, double mounting_attitude,
                                                 double mounting_position) const {
  const double n = bearings_;
  return variance_of_mean(last_time_ - first_time_, correlation_time) *
             pose_part(near, base_sum_ / n, pose_covariance_sum_ / n) +
         mounting_part(near, eye_sum_ / n, mounting_attitude, mounting_position);
}

double place_on_line(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray,
                     const Eigen::Vector3d& origin, const Eigen::Vector3d& along) {
  const double cosine = ray.dot(along);
  const double squared_sine = 1 - cosine * cosine;
  if (squared_sine < 1e-6) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const Eigen::Vector3d from_origin = eye - origin;
  return (from_origin.dot(along) - cosine * from_origin.dot(ray)) / squared_sine;
}

Miss miss(const Bearing& bearing, const Eigen::Vector3d& point,
          const Eigen::Matrix3d& point_covariance) {
  Eigen::Matrix<double, 2, 3> rows;
  rows.row(0) = bearing.along;
  rows.row(1) = bearing.ray.cross(bearing.along);
  const Eigen::Vector3d to_point = point - bearing.eye;
  const double range = to_point.norm();
  const double jitter = bearing.position_jitter * bearing.position_jitter;
  Miss m;
  m.offset = -rows * to_point;
  m.covariance = rows * point_covariance * rows.transpose();
  m.covariance(0, 0) += std::pow(range * bearing.along_deviation, 2) + jitter;
  m.covariance(1, 1) += std::pow(range * bearing.across_deviation, 2) + jitter;
  return m;
}

Eigen::Matrix3d pose_part(const Eigen::Vector3d& point, const Eigen::Vector3d& base,
                          const geometry::Matrix6d& pose_covariance) {
  Eigen::Matrix<double, 3, 6> by_pose;
  by_pose << Eigen::Matrix3d::Identity(), -geometry::skew(point - base);
  return by_pose * pose_covariance * by_pose.transpose();
}

Eigen::Matrix3d mounting_part(const Eigen::Vector3d& point, const Eigen::Vector3d& eye,
                              double attitude, double position) {
  const Eigen::Matrix3d turn = attitude * geometry::skew(point - eye);
  return turn * turn.transpose() + position * position * Eigen::Matrix3d::Identity();
}

double variance_of_mean(double duration, double correlation_time) {
  const double x = duration / correlation_time;
  if (x < 1e-4) {
    return 1 - x / 3;
  }
  return 2 * (x + std::expm1(-x)) / (x * x);
}

MapPosition fuse(const MapPosition& a, const MapPosition& b) {
  MapPosition both = b;
  const Eigen::Matrix3d gain = a.covariance * inverse(Eigen::Matrix3d(a.covariance + b.covariance));
  both.point = a.point + gain * (b.point - a.point);
  const Eigen::Matrix3d rest = (Eigen::Matrix3d::Identity() - gain) * a.covariance;
  both.covariance = 0.5 * (rest + rest.transpose());
  return both;
}

}  // namespace pipescout::leak_findings
