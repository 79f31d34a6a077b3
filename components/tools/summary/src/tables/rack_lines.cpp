// SPDX-License-Identifier: Apache-2.0
#include "tables/rack_lines.hpp"

#include <cmath>
#include <cstdint>

#include "pipescout/csv/csv_line.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout::summary {

namespace {

using pipescout_msgs::msg::RackState;

const char* status_text(std::uint8_t status) {
  switch (status) {
    case RackState::STATUS_NOT_STARTED:
      return "not started";
    case RackState::STATUS_TRACKING:
      return "tracking";
    case RackState::STATUS_LOST:
      return "lost";
    case RackState::STATUS_BAD_IMAGE:
      return "bad image";
    default:
      return "unknown";
  }
}

}  // namespace

std::string state_csv_header() {
  return "stamp,status,quality,reason,inlier_share,edges,edge_samples,edge_samples_found,"
         "texture_points,texture_points_matched,map_points,along_standard_deviation,losses";
}

std::string state_csv_line(const pipescout_msgs::msg::RackState& message) {
  CsvLine line(from_message(message.header.stamp));
  line.add(status_text(message.status)).add(message.quality).add(message.reason);
  line.add(message.inlier_share);
  for (const std::uint64_t count :
       {message.edges, message.edge_samples, message.edge_samples_found, message.texture_points,
        message.texture_points_matched, message.map_points}) {
    line.add(count);
  }
  return line.add(message.along_standard_deviation).add(message.losses).text();
}

std::string offset_csv_header() {
  return "stamp,pipe,offset,standard_deviation,observed";
}

std::string offset_csv_line(const pipescout_msgs::msg::RackState& message, std::size_t pipe) {
  return CsvLine(from_message(message.header.stamp))
      .add(message.pipe[pipe])
      .add(message.offset[pipe])
      .add(std::sqrt(message.offset_variance[pipe]))
      .add(static_cast<bool>(message.offset_observed[pipe]))
      .text();
}

std::string command_csv_header() {
  return "stamp,linear_x,linear_y,linear_z,angular_x,angular_y,angular_z";
}

std::string command_csv_line(const geometry_msgs::msg::TwistStamped& message) {
  CsvLine line(from_message(message.header.stamp));
  for (const auto& vector : {message.twist.linear, message.twist.angular}) {
    line.add(vector.x).add(vector.y).add(vector.z);
  }
  return line.text();
}

std::string way_point_csv_header() {
  return "stamp,done,of,message";
}

std::string way_point_csv_line(const pipescout_msgs::msg::MissionStatus& message) {
  return CsvLine(from_message(message.header.stamp))
      .add(std::uint64_t{message.done})
      .add(std::uint64_t{message.total})
      .add(message.message)
      .text();
}

std::string image_csv_header() {
  return "stamp,file";
}

std::string image_csv_line(Time stamp, const std::string& file) {
  return CsvLine(stamp).add(file).text();
}

}  // namespace pipescout::summary
