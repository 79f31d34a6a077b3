// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sensor_msgs/msg/nav_sat_fix.hpp>

#include "pipescout/estimation/factors.hpp"
#include "pipescout/geometry/geodesy.hpp"

/// Measurements from fixes of GPS. All functions are pure.
namespace pipescout {

/// Of a fix; throws std::invalid_argument naming the field when it is none: latitude, longitude.
/// The altitude is 0 where it is not known.
[[nodiscard]] geometry::GeodeticPosition geodetic(const sensor_msgs::msg::NavSatFix& message);

/// Whether its covariance says anything: receivers send NaN, zeros and -1 for an unknown one too.
[[nodiscard]] bool covariance_is_stated(const sensor_msgs::msg::NavSatFix& message);

/// `deviation`, m per axis, is that of fixes whose covariance is not known (0: such fixes are
/// errors), `least_deviation` the least one of any. A height that is not known is `expected_height`
/// (m, in the map) give or take very much. Throws as `geodetic`, and for an unknown covariance.
[[nodiscard]] estimation::GpsMeasurement gps_measurement(const sensor_msgs::msg::NavSatFix& message,
                                                         double time,
                                                         const geometry::LocalFrame& frame,
                                                         double expected_height, double deviation,
                                                         double least_deviation);

}  // namespace pipescout
