// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

/// Conversions between geodetic positions on the WGS 84 ellipsoid and a local frame, by
/// GeographicLib.
namespace pipescout::geometry {

/// As sensor_msgs/NavSatFix gives it.
struct GeodeticPosition {
  double latitude = 0;   ///< degrees, north positive, in [-90, 90]
  double longitude = 0;  ///< degrees, east positive, in [-540, 540]
  double altitude = 0;   ///< m above the ellipsoid, not above sea level

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// The length of the straight line between two places, m: of 10 km less than the way along the
/// ellipsoid by 1 mm. NaN for what is not finite and for latitudes beyond the poles; not checked.
[[nodiscard]] double straight_distance(const GeodeticPosition& a, const GeodeticPosition& b);

/// A local Cartesian frame with the ellipsoid's normal at its datum as z axis: x east, y north, z
/// up (REP 103). At a distance of 1 km z deviates from the local vertical by 0.16 mrad, and the
/// ellipsoid is 8 cm below the plane.
class LocalFrame {
 public:
  /// The datum becomes (0, 0, 0). Throws as GeodeticPosition::validate.
  explicit LocalFrame(const GeodeticPosition& datum);

  [[nodiscard]] const GeodeticPosition& datum() const noexcept { return datum_; }
  /// m. Throws as GeodeticPosition::validate.
  [[nodiscard]] Eigen::Vector3d position(const GeodeticPosition& geodetic) const;
  /// The inverse. Throws std::invalid_argument when `position` (m) is not finite.
  [[nodiscard]] GeodeticPosition geodetic(const Eigen::Vector3d& position) const;
  /// The rotation from east, north, up at a position (the axes of a GPS receiver's covariance) to
  /// this frame. Throws as GeodeticPosition::validate.
  [[nodiscard]] Eigen::Matrix3d axes_at(const GeodeticPosition& geodetic) const;

  /// The rotation from geocentric (Earth-centred, Earth-fixed) axes to those of this frame.
  [[nodiscard]] const Eigen::Matrix3d& R_local_geocentric() const noexcept {
    return R_local_geocentric_;
  }
  /// Of a geocentric position, m.
  [[nodiscard]] Eigen::Vector3d from_geocentric(const Eigen::Vector3d& position) const noexcept;

 private:
  GeodeticPosition datum_;
  Eigen::Vector3d origin_;  // geocentric, m
  Eigen::Matrix3d R_local_geocentric_;
};

}  // namespace pipescout::geometry
