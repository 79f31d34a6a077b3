// SPDX-License-Identifier: Apache-2.0
#include "pipescout/geometry/geodesy.hpp"

#include <GeographicLib/Geocentric.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace pipescout::geometry {

namespace {

struct Geocentric {
  Eigen::Vector3d position;
  Eigen::Matrix3d R_geocentric_enu;
};

void require(bool good, const char* field, double value, const char* range) {
  if (!good) {
    throw std::invalid_argument(std::string(field) + " is " + std::to_string(value) +
                                "; it must be " + range);
  }
}

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
  require(latitude >= -90 && latitude <= 90, "latitude", latitude, "in [-90, 90] degrees");
  require(longitude >= -540 && longitude <= 540, "longitude", longitude, "in [-540, 540] degrees");
  require(altitude >= -1e7 && altitude <= 1e7, "altitude", altitude, "in [-1e7, 1e7] m");
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
