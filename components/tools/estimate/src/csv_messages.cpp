// SPDX-License-Identifier: Apache-2.0
#include "csv_messages.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "pipescout/command_line/known_keys.hpp"
#include "pipescout/files/yaml_location.hpp"
#include "pipescout/message_conversions/motion.hpp"

namespace pipescout::estimate {
namespace {

using geometry_msgs::msg::TwistStamped;
using geometry_msgs::msg::TwistWithCovarianceStamped;

constexpr double kRadian = std::numbers::pi / 180;  // of a degree

/// A message for each row.
template <class MessageOf>
void read_rows(const CsvSource& source, const CsvColumns& columns, Stream& stream,
               MessageOf&& message_of) {
  const std::size_t time = columns.one("time");
  for (const std::size_t row : source.rows()) {
    add_further(stream, columns.time(row, time), message_of(row));
  }
}

/// Along the axes of the map: of its components, or of speed and course over ground (degrees,
/// clockwise from north), as receivers say it.
void read_gps_velocity(const CsvSource& source, const CsvColumns& columns, Stream& stream) {
  if (columns.has("course")) {
    const std::size_t speed = columns.one("speed");
    const std::size_t course = columns.one("course");
    read_rows(source, columns, stream, [&](const std::size_t row) {
      const double v = columns.number(row, speed);
      const double angle = kRadian * columns.number(row, course);
      TwistStamped message;
      message.twist.linear =
          to_message(Eigen::Vector3d{v * std::sin(angle), v * std::cos(angle), 0});
      return message;
    });
    return;
  }
  const auto velocity = columns.all("velocity", 2);
  read_rows(source, columns, stream, [&](const std::size_t row) {
    TwistStamped message;
    message.twist.linear = to_message(
        Eigen::Vector3d{columns.number(row, velocity[0]), columns.number(row, velocity[1]), 0});
    return message;
  });
}

void read_velocity(const CsvSource& source, const CsvColumns& columns, Stream& stream) {
  const auto velocity = columns.all("velocity", 3);
  const bool stated = columns.has("variance");
  const auto variance = stated ? columns.all("variance", 3) : std::vector<std::size_t>{};
  read_rows(source, columns, stream, [&](const std::size_t row) {
    TwistWithCovarianceStamped message;
    message.twist.twist.linear = to_message(columns.vector(row, velocity));
    for (std::size_t i = 0; i < variance.size(); ++i) {
      message.twist.covariance[7 * i] = columns.number(row, variance[i]);
    }
    return message;
  });
}

/// Of Odometry and PoseWithCovarianceStamped.
template <class Message>
void read_poses(const CsvSource& source, const CsvColumns& columns, Stream& stream) {
  const auto position = columns.all("position", 3);
  const auto orientation = columns.all("orientation", 4);
  read_rows(source, columns, stream, [&](const std::size_t row) {
    Message message;
    const Eigen::Vector3d p = columns.vector(row, position);
    auto& pose = message.pose.pose;
    pose.position.x = p.x();
    pose.position.y = p.y();
    pose.position.z = p.z();
    pose.orientation.x = columns.number(row, orientation[0]);
    pose.orientation.y = columns.number(row, orientation[1]);
    pose.orientation.z = columns.number(row, orientation[2]);
    pose.orientation.w = columns.number(row, orientation[3]);
    return message;
  });
}

void read_fixes(const CsvSource& source, const CsvColumns& columns, Stream& stream) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::size_t latitude = columns.one("latitude");
  const std::size_t longitude = columns.one("longitude");
  const bool has_height = columns.has("height");
  const std::size_t height = has_height ? columns.one("height") : 0;
  const bool stated = columns.has("variance");
  const auto variance = stated ? columns.all("variance", 3) : std::vector<std::size_t>{};
  const bool has_status = columns.has("status");
  const std::size_t status = has_status ? columns.one("status") : 0;
  read_rows(source, columns, stream, [&](const std::size_t row) {
    sensor_msgs::msg::NavSatFix message;
    message.latitude = columns.number(row, latitude);
    message.longitude = columns.number(row, longitude);
    message.altitude = has_height ? columns.number(row, height) : kNan;
    if (has_status && columns.number(row, status) < 0) {
      message.status.status = sensor_msgs::msg::NavSatStatus::STATUS_NO_FIX;
    }
    if (stated) {
      message.position_covariance_type =
          sensor_msgs::msg::NavSatFix::COVARIANCE_TYPE_DIAGONAL_KNOWN;
      for (std::size_t i = 0; i < variance.size(); ++i) {
        message.position_covariance[4 * i] = columns.number(row, variance[i]);
      }
    }
    return message;
  });
}

}  // namespace

std::string kinds_in_csv_files() {
  return "gps_velocity, gps_velocity_with_covariance, base_velocity, odometry_pose, "
         "magnetic_field, fluid_pressure, range, gps_fix or pose";
}

void read_messages(NamedSourceKind kind, const CsvSource& source, const CsvColumns& columns,
                   const YAML::Node& columns_node, const std::string& mapping, Stream& stream) {
  stream.kind = Kind::kFurther;
  stream.message_type = std::string(message_type_of(kind));
  const auto known = [&](const std::vector<std::string>& keys) {
    command_line::require_known_keys(columns_node, mapping, "'columns'", keys);
  };
  switch (kind) {
    case NamedSourceKind::kGpsVelocity:
      known({"time", "velocity", "speed", "course"});
      read_gps_velocity(source, columns, stream);
      return;
    case NamedSourceKind::kGpsVelocityWithCovariance:
    case NamedSourceKind::kBaseVelocity:
      known({"time", "velocity", "variance"});
      read_velocity(source, columns, stream);
      return;
    case NamedSourceKind::kOdometryPose:
      known({"time", "position", "orientation"});
      read_poses<nav_msgs::msg::Odometry>(source, columns, stream);
      return;
    case NamedSourceKind::kPose:
      known({"time", "position", "orientation"});
      read_poses<geometry_msgs::msg::PoseWithCovarianceStamped>(source, columns, stream);
      return;
    case NamedSourceKind::kMagneticField: {
      known({"time", "field"});
      const auto field = columns.all("field", 3);
      read_rows(source, columns, stream, [&](const std::size_t row) {
        sensor_msgs::msg::MagneticField message;
        message.magnetic_field = to_message(columns.vector(row, field));
        return message;
      });
      return;
    }
    case NamedSourceKind::kFluidPressure: {
      known({"time", "pressure"});
      const std::size_t pressure = columns.one("pressure");
      read_rows(source, columns, stream, [&](const std::size_t row) {
        sensor_msgs::msg::FluidPressure message;
        message.fluid_pressure = columns.number(row, pressure);
        return message;
      });
      return;
    }
    case NamedSourceKind::kRange: {
      known({"time", "range"});
      const std::size_t range = columns.one("range");
      read_rows(source, columns, stream, [&](const std::size_t row) {
        sensor_msgs::msg::Range message;
        message.range = static_cast<float>(columns.number(row, range));
        return message;
      });
      return;
    }
    case NamedSourceKind::kGpsFix:
      known({"time", "latitude", "longitude", "height", "variance", "status"});
      read_fixes(source, columns, stream);
      return;
    case NamedSourceKind::kOdometryVelocity:
    case NamedSourceKind::kWheelEncoders:
      break;
  }
  throw YamlError(mapping, columns_node.Mark(),
                  "kind " + std::string(to_string(kind)) + " is of bags; a CSV file may hold " +
                      kinds_in_csv_files());
}

}  // namespace pipescout::estimate
