// SPDX-License-Identifier: Apache-2.0
#include "tables/estimator_lines.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "pipescout/csv/csv_line.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"
#include "pipescout/mission_tables/pose_csv.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout::summary {

namespace {

/// "NAME_x,NAME_y,NAME_z", the same with `ending` behind each, after a comma.
std::string axes(const std::string& name, const std::string& ending = "") {
  std::string columns;
  for (const char* axis : {"_x", "_y", "_z"}) {
    columns += "," + name;
    columns += axis + ending;
  }
  return columns;
}

constexpr const char* kDeviation = "_standard_deviation";

/// Of variances, row-major; those that rounding has made negative count as none.
template <std::size_t Size>
void add_deviations(CsvLine& line, const std::array<double, Size>& covariance) {
  constexpr std::size_t kAxes = 6;
  static_assert(Size == kAxes * kAxes);
  for (std::size_t k = 0; k < kAxes; ++k) {
    line.add_short(std::sqrt(std::max(0.0, covariance.at(k * kAxes + k))));
  }
}

void add_rack(CsvLine& line, const geometry_msgs::msg::PoseWithCovariance& rack) {
  if (!(rack.covariance[0] > 0)) {
    line.add_empty(12);
    return;
  }
  const geometry::SE3 T_map_rack = from_message(rack.pose);
  line.add_each(T_map_rack.translation()).add_each(T_map_rack.rotation().roll_pitch_yaw());
  add_deviations(line, rack.covariance);
}

}  // namespace

std::string estimate_csv_header() {
  return uncertain_pose_csv_header() + axes("linear") + axes("angular") +
         axes("linear", kDeviation) + axes("angular", kDeviation);
}

std::string estimate_csv_line(const nav_msgs::msg::Odometry& message,
                              const geometry::SE3& T_map_base,
                              const geometry::Matrix6d& covariance) {
  CsvLine line =
      uncertain_pose_csv_line(from_message(message.header.stamp), T_map_base, covariance);
  line.add_each(from_message(message.twist.twist.linear))
      .add_each(from_message(message.twist.twist.angular));
  add_deviations(line, message.twist.covariance);
  return line.text();
}

std::string error_csv_header() {
  std::string header = "stamp";
  for (const char* axis : kPoseAxes) {
    header += std::string(",") + axis;
  }
  return header + ",position_nees,pose_nees";
}

std::string error_csv_line(Time stamp, const EstimatorReport::Error& error) {
  return CsvLine(stamp)
      .add_each(error.error)
      .add_short(error.position_nees)
      .add_short(error.pose_nees)
      .text();
}

std::string estimator_state_csv_header() {
  return "stamp,phase,waits_for,standing_still,since_absolute_position,restarts,restart_reason" +
         axes("gyro_bias") + axes("gyro_bias", kDeviation) + axes("accelerometer_bias") +
         axes("accelerometer_bias", kDeviation) +
         ",odometer_scale,odometer_scale_standard_deviation,rack_x,rack_y,rack_z,rack_roll,"
         "rack_pitch,rack_yaw" +
         axes("rack", kDeviation) + axes("rack_rotation", kDeviation);
}

std::string estimator_state_csv_line(const pipescout_msgs::msg::EstimatorState& message) {
  CsvLine line(from_message(message.header.stamp));
  line.add(message.phase)
      .add(message.waits_for)
      .add(message.standing_still)
      .add(message.since_absolute_position)
      .add(std::uint64_t{message.restarts})
      .add(message.restart_reason);
  if (message.phase != "running" && message.phase != "coasting") {
    return line.add_empty(26).text();
  }
  line.add_each(from_message(message.gyro_bias))
      .add_each_short(from_message(message.gyro_bias_deviation))
      .add_each(from_message(message.accelerometer_bias))
      .add_each_short(from_message(message.accelerometer_bias_deviation));
  if (message.odometer_scale_deviation > 0) {
    line.add(message.odometer_scale).add_short(message.odometer_scale_deviation);
  } else {
    line.add_empty(2);
  }
  add_rack(line, message.rack);
  return line.text();
}

std::string factor_csv_header() {
  return "stamp,kind,outcome,chi_square,degrees,weight";
}

std::string factor_csv_line(const pipescout_msgs::msg::EstimatorState& message,
                            std::size_t factor) {
  return CsvLine(from_message(message.factor_stamp[factor]))
      .add(message.factor[factor])
      .add(message.factor_outcome[factor])
      .add_short(message.factor_chi_square[factor])
      .add(std::uint64_t{message.factor_degrees[factor]})
      .add_short(message.factor_weight[factor])
      .text();
}

std::string source_csv_header() {
  return "stamp,source,state,accepted,gated,held,refused";
}

std::string source_csv_line(const pipescout_msgs::msg::EstimatorState& message,
                            std::size_t source) {
  return CsvLine(from_message(message.header.stamp))
      .add(message.source[source])
      .add(message.source_state[source])
      .add(std::uint64_t{message.source_accepted[source]})
      .add(std::uint64_t{message.source_gated[source]})
      .add(std::uint64_t{message.source_held[source]})
      .add(std::uint64_t{message.source_refused[source]})
      .text();
}

std::string gps_csv_header() {
  return "stamp,latitude,longitude,altitude,x,y,z";
}

std::string gps_csv_line(const GpsPlace& fix, const Eigen::Vector3d& position) {
  return CsvLine(fix.stamp)
      .add(fix.place.latitude)
      .add(fix.place.longitude)
      .add(fix.place.altitude)
      .add_each(position)
      .text();
}

}  // namespace pipescout::summary
