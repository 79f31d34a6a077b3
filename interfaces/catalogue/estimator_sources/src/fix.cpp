// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimator_sources/fix.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace pipescout {

namespace {

using sensor_msgs::msg::NavSatFix;

/// m; a height that is not known.
constexpr double kUnknownHeight = 1e4;

}  // namespace

geometry::GeodeticPosition geodetic(const sensor_msgs::msg::NavSatFix& message) {
  const geometry::GeodeticPosition result{message.latitude, message.longitude,
                                          std::isnan(message.altitude) ? 0.0 : message.altitude};
  result.validate();
  return result;
}

bool covariance_is_stated(const NavSatFix& message) {
  const auto& c = message.position_covariance;
  const bool numbers = std::ranges::all_of(c, [](double value) { return std::isfinite(value); });
  const auto [least, most] = std::minmax({c[0], c[4], c[8]});
  return message.position_covariance_type != NavSatFix::COVARIANCE_TYPE_UNKNOWN && numbers &&
         least >= 0 && most > 0;
}

estimation::GpsMeasurement gps_measurement(const sensor_msgs::msg::NavSatFix& message, double time,
                                           const geometry::LocalFrame& frame,
                                           double expected_height, double deviation,
                                           double least_deviation) {
  const geometry::GeodeticPosition place = geodetic(message);
  estimation::GpsMeasurement result;
  result.time = time;
  result.position = frame.position(place);
  if (!covariance_is_stated(message)) {
    if (deviation <= 0) {
      throw std::invalid_argument(
          "position_covariance states nothing usable, and parameter 'gps.deviation' is 0");
    }
    result.covariance.diagonal().setConstant(deviation * deviation);
  } else {
    const Eigen::Matrix3d axes = frame.axes_at(place);
    const Eigen::Matrix3d given = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
        message.position_covariance.data());
    result.covariance = axes * given * axes.transpose();
    result.covariance = (0.5 * (result.covariance + result.covariance.transpose())).eval();
    // Added, not put in its place: a correlation stays one.
    const double least = least_deviation * least_deviation;
    const double lacking = least - result.covariance.diagonal().minCoeff();
    if (lacking > 0) {
      result.covariance.diagonal().array() += lacking;
    }
  }
  if (std::isnan(message.altitude)) {
    result.position.z() = expected_height;
    result.covariance.row(2).setZero();
    result.covariance.col(2).setZero();
    result.covariance(2, 2) = kUnknownHeight * kUnknownHeight;
  }
  return result;
}

}  // namespace pipescout
