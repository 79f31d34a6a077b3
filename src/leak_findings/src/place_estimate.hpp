// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/leak_findings/finding.hpp"

namespace pipescout::leak_findings {

/// Where the middle of a leak is seen from one place.
struct Bearing {
  double time = 0;
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();     ///< m, the camera, in the map
  Eigen::Vector3d ray = Eigen::Vector3d::UnitX();    ///< unit, in the map
  Eigen::Vector3d along = Eigen::Vector3d::UnitY();  ///< unit, across the ray: where the pipe goes
  double along_deviation = 0;                        ///< rad
  double across_deviation = 0;                       ///< rad
  double position_jitter = 0;                        ///< m
  Eigen::Vector3d base = Eigen::Vector3d::Zero();    ///< m, of the pose, in the map
  geometry::Matrix6d pose_covariance = geometry::Matrix6d::Zero();  ///< as `FramePose`
};

/// What is known of a point before it is seen from several places.
struct RangePrior {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< 1/m^2
  double range = 0;                                       ///< m, from the eye
};

/// The point that bearings of one pass meet at, by least squares. Errors of the poses that stay the
/// same throughout the pass are left out of the sums, and come on top in the end: frames do not
/// average them out.
class PlaceEstimate {
 public:
  void clear() { *this = PlaceEstimate{}; }
  [[nodiscard]] bool empty() const noexcept { return bearings_ == 0; }
  /// Begins with what is known of the range.
  void begin(const Bearing& bearing, const RangePrior& prior);
  /// After `begin`.
  void add(const Bearing& bearing);

  /// After `begin`.
  [[nodiscard]] Eigen::Vector3d point() const;
  /// m^2, but for what is common to all bearings.
  [[nodiscard]] Eigen::Matrix3d relative_covariance() const;
  /// m^2, what is common to all bearings, for a point near `point()`. `correlation_time`: s, of the
  /// errors of the pose; deviations of the camera's mounting, rad and m, which stay.
  [[nodiscard]] Eigen::Matrix3d common_covariance(const Eigen::Vector3d& near,
                                                  double correlation_time, double mounting_attitude,
                                                  double mounting_position) const;

 private:
  void add_row(const Eigen::Vector3d& row, double value, double deviation);

  int bearings_ = 0;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d weighted_ = Eigen::Vector3d::Zero();
  double first_time_ = 0;
  double last_time_ = 0;
  Eigen::Vector3d eye_sum_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d base_sum_ = Eigen::Vector3d::Zero();
  geometry::Matrix6d pose_covariance_sum_ = geometry::Matrix6d::Zero();
};

/// How far a bearing is from a point: (along, across), m, at the distance of the point, and what
/// their covariance is when the point has that covariance.
struct Miss {
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();
};
[[nodiscard]] Miss miss(const Bearing& bearing, const Eigen::Vector3d& point,
                        const Eigen::Matrix3d& point_covariance);

/// Place along the line through `origin` with the unit direction `along` that a ray comes nearest
/// to, m; NaN when they are parallel.
[[nodiscard]] double place_on_line(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray,
                                   const Eigen::Vector3d& origin, const Eigen::Vector3d& along);

/// m^2, of a point that is placed by a pose with that covariance.
[[nodiscard]] Eigen::Matrix3d pose_part(const Eigen::Vector3d& point, const Eigen::Vector3d& base,
                                        const geometry::Matrix6d& pose_covariance);

/// m^2, of a point that is placed by a camera that is off by angles and a place of these deviations
/// per axis, rad and m.
[[nodiscard]] Eigen::Matrix3d mounting_part(const Eigen::Vector3d& point,
                                            const Eigen::Vector3d& eye, double attitude,
                                            double position);

/// The share of the variance of an error with a correlation time that is left in its mean over a
/// duration: 1 for none.
[[nodiscard]] double variance_of_mean(double duration, double correlation_time);

/// Both are of one point, and their errors have nothing in common.
[[nodiscard]] MapPosition fuse(const MapPosition& a, const MapPosition& b);

}  // namespace pipescout::leak_findings
