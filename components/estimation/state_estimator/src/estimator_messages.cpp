// SPDX-License-Identifier: Apache-2.0
#include "estimator_messages.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout {

namespace {

using estimation::FactorReport;
using estimation::Outcome;
using estimation::Phase;
using estimation::Source;
using estimation::SourceStatus;
using pipescout_msgs::msg::FusedOdometer;

/// Variances that rounding has made negative count as none.
geometry_msgs::msg::Vector3 deviations(const Eigen::Vector3d& variances) {
  return to_message(Eigen::Vector3d(variances.cwiseMax(0).cwiseSqrt()));
}

void add_sources(const estimation::EstimatorStatus& status, const std::vector<NamedSource>& named,
                 pipescout_msgs::msg::EstimatorState& message) {
  const auto add = [&](std::string_view name, const SourceStatus& source) {
    message.source.emplace_back(name);
    message.source_state.emplace_back(to_string(source.state));
    message.source_accepted.push_back(source.accepted);
    message.source_gated.push_back(source.gated);
    message.source_held.push_back(source.held);
    message.source_refused.push_back(source.refused);
  };
  for (std::size_t i = 0; i < estimation::kSources; ++i) {
    add(to_string(static_cast<Source>(i)), status.sources[i]);
  }
  for (std::size_t i = 0; i < named.size(); ++i) {
    add(named[i].name, status.own_sources[i]);
  }
}

/// Of a kind of factors: that of the named source whose they are.
std::string_view name_of(estimation::FactorKind kind, const std::vector<NamedSource>& named) {
  for (std::size_t i = 0; i < named.size(); ++i) {
    if (kind == estimation::own_kind(i)) {
      return named[i].name;
    }
  }
  return to_string(kind);
}

void add_factors(const estimation::UpdateReport& report, Time origin,
                 const std::vector<NamedSource>& named,
                 pipescout_msgs::msg::EstimatorState& message) {
  for (const FactorReport& factor : report.factors) {
    message.factor.emplace_back(name_of(factor.kind, named));
    message.factor_stamp.push_back(to_message(origin + from_seconds(factor.time)));
    message.factor_outcome.emplace_back(to_string(factor.outcome));
    message.factor_chi_square.push_back(factor.chi_square);
    message.factor_degrees.push_back(static_cast<std::uint8_t>(factor.degrees));
    message.factor_weight.push_back(factor.weight);
  }
}

void add_states(const estimation::FixedLagSmoother& smoother,
                pipescout_msgs::msg::EstimatorState& message) {
  const std::size_t newest = smoother.keyframes() - 1;
  const estimation::NavState& state = smoother.state(newest);
  const estimation::StateMatrix covariance = smoother.covariance(newest);
  message.gyro_bias = to_message(state.gyro_bias);
  message.gyro_bias_deviation = deviations(covariance.diagonal().segment<3>(estimation::kGyroBias));
  message.accelerometer_bias = to_message(state.accelerometer_bias);
  message.accelerometer_bias_deviation =
      deviations(covariance.diagonal().segment<3>(estimation::kAccelerometerBias));
  const estimation::GlobalStates& globals = smoother.globals();
  const auto global_covariance = smoother.global_covariance();
  message.odometer_scale = globals.odometer_scale;
  message.odometer_scale_deviation = std::sqrt(
      std::max(0.0, global_covariance(estimation::kOdometerScale, estimation::kOdometerScale)));
  message.rack.pose = to_message(geometry::SE3(globals.R_map_rack, globals.rack_position));
  // Rotations of the state are about the axes of the rack, those of the message about the map's.
  geometry::Matrix6d by_state = geometry::Matrix6d::Identity();
  by_state.bottomRightCorner<3, 3>() = globals.R_map_rack.matrix();
  const geometry::Matrix6d rack =
      global_covariance.block<6, 6>(estimation::kRackPosition, estimation::kRackPosition);
  message.rack.covariance = to_message(geometry::Matrix6d(by_state * rack * by_state.transpose()));
}

}  // namespace

estimation::ImuReading imu_reading(const sensor_msgs::msg::Imu& message, double time) {
  return {.time = time,
          .specific_force = from_message(message.linear_acceleration),
          .angular_rate = from_message(message.angular_velocity)};
}

std::optional<estimation::HeadingMeasurement> heading(const sensor_msgs::msg::Imu& message,
                                                      double time,
                                                      const EstimatorSettings& settings) {
  const double variance = message.orientation_covariance[8];
  if (message.orientation_covariance[0] == -1) {
    return std::nullopt;
  }
  geometry_msgs::msg::Pose pose;
  pose.orientation = message.orientation;
  const geometry::SO3 R_map_body =
      from_message(pose).rotation() * settings.estimator.R_body_imu.inverse();
  const Eigen::Vector3d forwards = R_map_body * Eigen::Vector3d::UnitX();
  return estimation::HeadingMeasurement{
      .time = time,
      .heading = std::atan2(forwards.y(), forwards.x()),
      .standard_deviation = variance > 0 ? std::sqrt(variance) : settings.heading_deviation};
}

estimation::OdometerReading odometer_reading(const pipescout_msgs::msg::FusedOdometer& message,
                                             double time) {
  estimation::OdometerReading result{
      .time = time, .distance = message.distance, .variance = message.independent_variance};
  if (!std::isfinite(result.variance)) {
    result.variance = message.variance;
  }
  switch (message.status) {
    case FusedOdometer::STATUS_OK:
      break;
    case FusedOdometer::STATUS_NO_CONSENSUS:
      result.status = estimation::OdometerStatus::kNoConsensus;
      break;
    default:
      result.status = estimation::OdometerStatus::kNoData;
  }
  return result;
}

estimation::GpsMeasurement gps_measurement(const sensor_msgs::msg::NavSatFix& message, double time,
                                           const geometry::LocalFrame& frame,
                                           double expected_height,
                                           const EstimatorSettings& settings) {
  return gps_measurement(message, time, frame, expected_height, settings.gps_deviation,
                         settings.least_gps_deviation);
}

geometry_msgs::msg::TransformStamped transform(const geometry::SE3& T_parent_child, Time stamp,
                                               const std::string& parent,
                                               const std::string& child) {
  const geometry_msgs::msg::Pose pose = to_message(T_parent_child);
  geometry_msgs::msg::TransformStamped message;
  message.header.stamp = to_message(stamp);
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.transform.translation = to_message(T_parent_child.translation());
  message.transform.rotation = pose.orientation;
  return message;
}

pipescout_msgs::msg::EstimatorState state_message(const estimation::StateEstimator& estimator,
                                                  const estimation::EstimatorStatus& status,
                                                  Time origin,
                                                  const std::vector<NamedSource>& named) {
  pipescout_msgs::msg::EstimatorState message;
  message.phase = std::string(to_string(status.phase));
  message.waits_for = status.text;
  message.standing_still = status.standing_still;
  message.since_absolute_position = status.since_absolute_position;
  message.restarts =
      std::accumulate(status.restarts.begin(), status.restarts.end(), std::size_t{0});
  message.restart_reason = std::string(to_string(status.last_restart));
  add_sources(status, named, message);
  add_factors(estimator.last_update(), origin, named, message);
  if ((status.phase == Phase::kRunning || status.phase == Phase::kCoasting) &&
      estimator.smoother().initialised()) {
    add_states(estimator.smoother(), message);
  }
  return message;
}

}  // namespace pipescout
