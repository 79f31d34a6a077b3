// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_recorder/csv_lines.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "pipescout/interfaces/conversions.hpp"
#include "pipescout/odometer_replay/csv_table.hpp"
#include "pipescout/odometer_replay/readings_csv.hpp"

namespace pipescout {

namespace {

namespace state_constants = pipescout_msgs::msg::RackState_Constants;

/// Of the tangent space, in the order of ROS covariances.
constexpr std::array kAxes{"x", "y", "z", "rotation_x", "rotation_y", "rotation_z"};
/// Characters of a text that are kept.
constexpr std::size_t kLongestText = 200;

std::string stamp_text(Time stamp) {
  return format_stamp(stamp.time_since_epoch());
}

/// Appends ",value"; -0 as 0.
void append(std::string& line, double value) {
  line += "," + format_csv_number(value + 0.0);
}
void append(std::string& line, std::uint64_t value) {
  line += "," + std::to_string(value);
}
/// With the digits of a float, which are enough for what describes an uncertainty.
void append_short(std::string& line, double value) {
  if (std::isnan(value)) {
    line += ",nan";
    return;
  }
  std::array<char, 32> buffer{};
  const auto result =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), static_cast<float>(value));
  line.append(",").append(buffer.data(), result.ptr);
}

/// RFC 4180, on one line.
std::string quoted(std::string text) {
  text.resize(std::min(text.size(), kLongestText));
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  if (text.find_first_of(",\"") == std::string::npos) {
    return text;
  }
  std::string result = "\"";
  for (const char c : text) {
    result += c == '"' ? "\"\"" : std::string(1, c);
  }
  return result + "\"";
}

const char* status_text(std::uint8_t status) {
  switch (status) {
    case state_constants::STATUS_NOT_STARTED:
      return "not started";
    case state_constants::STATUS_TRACKING:
      return "tracking";
    case state_constants::STATUS_LOST:
      return "lost";
    case state_constants::STATUS_BAD_IMAGE:
      return "bad image";
    default:
      return "unknown";
  }
}

}  // namespace

std::string truth_csv_header() {
  return "stamp,x,y,z,qx,qy,qz,qw,roll,pitch,yaw";
}

std::string truth_csv_line(Time stamp, const geometry::SE3& T_rack_camera) {
  std::string line = stamp_text(stamp);
  for (const double value : T_rack_camera.translation()) {
    append(line, value);
  }
  for (const double value : T_rack_camera.rotation().quaternion().coeffs()) {
    append(line, value);
  }
  for (const double value : T_rack_camera.rotation().roll_pitch_yaw()) {
    append(line, value);
  }
  return line;
}

std::string pose_csv_header() {
  std::string header = truth_csv_header();
  for (const char* axis : kAxes) {
    header += std::string(",") + axis + "_standard_deviation";
  }
  for (std::size_t i = 0; i < kAxes.size(); ++i) {
    for (std::size_t j = i + 1; j < kAxes.size(); ++j) {
      header += std::string(",") + kAxes[i] + "_" + kAxes[j] + "_correlation";
    }
  }
  return header;
}

std::string pose_csv_line(Time stamp, const geometry::SE3& T_rack_camera,
                          const geometry::Matrix6d& covariance) {
  std::string line = truth_csv_line(stamp, T_rack_camera);
  const geometry::Vector6d deviation = covariance.diagonal().cwiseSqrt();
  for (const double value : deviation) {
    append_short(line, value);
  }
  for (int i = 0; i < 6; ++i) {
    for (int j = i + 1; j < 6; ++j) {
      append_short(line, covariance(i, j) / (deviation[i] * deviation[j]));
    }
  }
  return line;
}

std::string state_csv_header() {
  return "stamp,status,quality,reason,inlier_share,edges,edge_samples,edge_samples_found,"
         "texture_points,texture_points_matched,map_points,along_standard_deviation,losses";
}

std::string state_csv_line(const pipescout_msgs::msg::RackState& message) {
  std::string line = stamp_text(from_message(message.header().stamp()));
  line += std::string(",") + status_text(message.status());
  append(line, message.quality());
  line += "," + quoted(message.reason());
  append(line, message.inlier_share());
  for (const std::uint64_t count :
       {message.edges(), message.edge_samples(), message.edge_samples_found(),
        message.texture_points(), message.texture_points_matched(), message.map_points()}) {
    append(line, count);
  }
  append(line, message.along_standard_deviation());
  append(line, message.losses());
  return line;
}

std::string offset_csv_header() {
  return "stamp,pipe,offset,standard_deviation,observed";
}

std::string offset_csv_line(const pipescout_msgs::msg::RackState& message, std::size_t pipe) {
  std::string line = stamp_text(from_message(message.header().stamp()));
  line += "," + quoted(message.pipe()[pipe]);
  append(line, message.offset()[pipe]);
  append(line, std::sqrt(message.offset_variance()[pipe]));
  line += message.offset_observed()[pipe] ? ",1" : ",0";
  return line;
}

std::string command_csv_header() {
  return "stamp,linear_x,linear_y,linear_z,angular_x,angular_y,angular_z";
}

std::string command_csv_line(const geometry_msgs::msg::TwistStamped& message) {
  std::string line = stamp_text(from_message(message.header().stamp()));
  for (const auto& vector : {message.twist().linear(), message.twist().angular()}) {
    append(line, vector.x());
    append(line, vector.y());
    append(line, vector.z());
  }
  return line;
}

std::string way_point_csv_header() {
  return "stamp,done,of,message";
}

std::string way_point_csv_line(const pipescout_msgs::msg::MissionStatus& message) {
  std::string line = stamp_text(from_message(message.header().stamp()));
  append(line, std::uint64_t{message.done()});
  append(line, std::uint64_t{message.total()});
  return line + "," + quoted(message.message());
}

std::string image_csv_header() {
  return "stamp,file";
}

std::string image_csv_line(Time stamp, const std::string& file) {
  return stamp_text(stamp) + "," + file;
}

}  // namespace pipescout
