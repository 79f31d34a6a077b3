// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <pipescout_msgs/msg/estimator_state.hpp>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <tf2_msgs/msg/tf_message.hpp>

#include "pipescout/estimation/state_estimator.hpp"
#include "pipescout/estimator_sources/fix.hpp"
#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/runtime/time.hpp"
#include "pipescout/state_estimator/estimator_settings.hpp"

/// Between messages and measurements. All functions are pure; times are s since an origin that the
/// caller keeps.
namespace pipescout {

/// Readings that are not finite are for the estimator to refuse.
[[nodiscard]] estimation::ImuReading imu_reading(const sensor_msgs::msg::Imu& message, double time);

/// The heading in it. Nothing where the driver says that there is no orientation. Throws
/// std::invalid_argument naming the field when it is none.
[[nodiscard]] std::optional<estimation::HeadingMeasurement> heading(
    const sensor_msgs::msg::Imu& message, double time, const EstimatorSettings& settings);

[[nodiscard]] estimation::OdometerReading odometer_reading(
    const pipescout_msgs::msg::FusedOdometer& message, double time);

/// With the standard deviations of `settings`; throws as that without them.
[[nodiscard]] estimation::GpsMeasurement gps_measurement(const sensor_msgs::msg::NavSatFix& message,
                                                         double time,
                                                         const geometry::LocalFrame& frame,
                                                         double expected_height,
                                                         const EstimatorSettings& settings);

[[nodiscard]] geometry_msgs::msg::TransformStamped transform(const geometry::SE3& T_parent_child,
                                                             Time stamp, const std::string& parent,
                                                             const std::string& child);

/// All but the header. `origin`: the time of 0; `named`: own sources, in their order.
[[nodiscard]] pipescout_msgs::msg::EstimatorState state_message(
    const estimation::StateEstimator& estimator, const estimation::EstimatorStatus& status,
    Time origin, const std::vector<NamedSource>& named = {});

}  // namespace pipescout
