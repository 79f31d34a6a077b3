// SPDX-License-Identifier: Apache-2.0
#include "pipescout/geometry/geodesy.hpp"

#include <GeographicLib/Geocentric.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/validation/check.hpp"

namespace pipescout::geometry {

namespace {

struct Geocentric {
  Eigen::Vector3d position;
  Eigen::Matrix3d R_geocentric_enu;
};

Geocentric to_geocentric(const GeodeticPosition& geodetic) {
  geodetic.validate();
  Geocentric result;
  std::vector<double> rotation(9);
  GeographicLib::Geocentric::WGS84().Forward(geodetic.latitude, geodetic.longitude,
                                             geodetic.altitude, result.position.x(),
                                             result.position.y(), result.position.z(), rotation);
  result.R_geocentric_enu =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation.data());
  return result;
}

}  // namespace

void GeodeticPosition::validate() const {
  validation::check_within("latitude", latitude, -90, 90);
  validation::check_within("longitude", longitude, -540, 540);
  validation::check_within("altitude", altitude, -1e7, 1e7);
}

double straight_distance(const GeodeticPosition& a, const GeodeticPosition& b) {
  const auto geocentric = [](const GeodeticPosition& p) {
    Eigen::Vector3d place;
    GeographicLib::Geocentric::WGS84().Forward(p.latitude, p.longitude, p.altitude, place.x(),
                                               place.y(), place.z());
    return place;
  };
  return (geocentric(b) - geocentric(a)).norm();
}

LocalFrame::LocalFrame(const GeodeticPosition& datum) : datum_(datum) {
  const Geocentric geocentric = to_geocentric(datum);
  origin_ = geocentric.position;
  R_local_geocentric_ = geocentric.R_geocentric_enu.transpose();
}

Eigen::Vector3d LocalFrame::position(const GeodeticPosition& geodetic) const {
  return from_geocentric(to_geocentric(geodetic).position);
}

GeodeticPosition LocalFrame::geodetic(const Eigen::Vector3d& position) const {
  if (!position.allFinite()) {
    throw std::invalid_argument("a position that is not finite has no latitude");
  }
  const Eigen::Vector3d geocentric = origin_ + R_local_geocentric_.transpose() * position;
  GeodeticPosition result;
  GeographicLib::Geocentric::WGS84().Reverse(geocentric.x(), geocentric.y(), geocentric.z(),
                                             result.latitude, result.longitude, result.altitude);
  return result;
}

Eigen::Matrix3d LocalFrame::axes_at(const GeodeticPosition& geodetic) const {
  return R_local_geocentric_ * to_geocentric(geodetic).R_geocentric_enu;
}

Eigen::Vector3d LocalFrame::from_geocentric(const Eigen::Vector3d& position) const noexcept {
  return R_local_geocentric_ * (position - origin_);
}

}  // namespace pipescout::geometry
