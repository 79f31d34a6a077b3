// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <nav_msgs/msg/odometry.hpp>
#include <pipescout_msgs/msg/estimator_state.hpp>
#include <string>

#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/runtime/time.hpp"
#include "tables/estimator_report.hpp"

/// The lines of an estimator's data files, docs/tables.md. Pure.
namespace pipescout::summary {

[[nodiscard]] std::string estimate_csv_header();
/// Pose and its covariance as given; the velocities from the message, which are finite. Not
/// checked.
[[nodiscard]] std::string estimate_csv_line(const nav_msgs::msg::Odometry& message,
                                            const geometry::SE3& T_map_base,
                                            const geometry::Matrix6d& covariance);

[[nodiscard]] std::string error_csv_header();
[[nodiscard]] std::string error_csv_line(Time stamp, const EstimatorReport::Error& error);

[[nodiscard]] std::string estimator_state_csv_header();
/// Throws std::invalid_argument when the rack's pose is none.
[[nodiscard]] std::string estimator_state_csv_line(
    const pipescout_msgs::msg::EstimatorState& message);

[[nodiscard]] std::string factor_csv_header();
/// The lists of the message are as long as `factor`. Not checked.
[[nodiscard]] std::string factor_csv_line(const pipescout_msgs::msg::EstimatorState& message,
                                          std::size_t factor);

[[nodiscard]] std::string source_csv_header();
/// The lists of the message are as long as `source`. Not checked.
[[nodiscard]] std::string source_csv_line(const pipescout_msgs::msg::EstimatorState& message,
                                          std::size_t source);

struct GpsPlace {
  Time stamp{};
  geometry::GeodeticPosition place;  ///< altitude NaN: not known
};
[[nodiscard]] std::string gps_csv_header();
/// `position`: m, in the map.
[[nodiscard]] std::string gps_csv_line(const GpsPlace& fix, const Eigen::Vector3d& position);

}  // namespace pipescout::summary
