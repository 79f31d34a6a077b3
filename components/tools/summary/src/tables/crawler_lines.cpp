// SPDX-License-Identifier: Apache-2.0
#include "tables/crawler_lines.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <type_traits>

#include "pipescout/catalogue/odometer_text.hpp"
#include "pipescout/csv/csv_cell.hpp"
#include "pipescout/odometer_readings/readings_csv.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout::summary {

namespace {

using pipescout_msgs::msg::PipePosition;

std::string stamp_text(const builtin_interfaces::msg::Time& stamp) {
  return format_stamp(from_message(stamp).time_since_epoch());
}

/// With the digits of a float, which are more than a converter has.
std::string short_number(double value) {
  if (std::isnan(value)) {
    return "nan";
  }
  std::array<char, 32> buffer{};
  const auto result =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), static_cast<float>(value));
  return {buffer.data(), result.ptr};
}

/// RFC 4180.
std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) {
    return text;
  }
  std::string result = "\"";
  for (const char c : text) {
    result += c == '"' ? "\"\"" : std::string(1, c);
  }
  return result + "\"";
}

/// Appends ",value" for each.
template <class... Values>
void append(std::string& line, const Values&... values) {
  const auto text = [](const auto& value) -> std::string {
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, double>) {
      return format_csv_number(value);
    } else if constexpr (std::is_same_v<Value, bool>) {
      return value ? "1" : "0";
    } else if constexpr (std::is_integral_v<Value>) {
      return std::to_string(value);
    } else {
      return value;
    }
  };
  ((line += "," + text(values)), ...);
}

/// "1>2 2>1 2>3": who supports whom, odometers counted from 1.
std::string support_text(const pipescout_msgs::msg::FusedOdometer& message) {
  const std::size_t m = message.name.size();
  std::string text;
  for (std::size_t i = 0; i < m; ++i) {
    for (std::size_t j = 0; j < m; ++j) {
      if (i != j && message.support[i * m + j] != 0) {
        text += (text.empty() ? "" : " ") + std::to_string(i + 1) + ">" + std::to_string(j + 1);
      }
    }
  }
  return text;
}

}  // namespace

std::string fused_csv_header(const std::vector<std::string>& columns) {
  std::string header = "stamp,distance,standard_deviation,speed,status,support";
  for (const std::string& column : columns) {
    header += "," + column + ".rejection," + column + ".health," + column + ".scale," + column +
              ".scale_standard_deviation";
  }
  return header;
}

std::string fused_csv_line(const pipescout_msgs::msg::FusedOdometer& message) {
  std::string line = stamp_text(message.header.stamp);
  append(line, message.distance, std::sqrt(message.variance), message.speed,
         std::string(fusion_status_text(message.status)), support_text(message));
  for (std::size_t i = 0; i < message.name.size(); ++i) {
    append(line, std::string(rejection_text(message.rejection_reason[i])));
    if (message.health.empty()) {
      line += ",,,";
    } else {
      append(line, std::string(health_text(message.health[i])), message.scale[i],
             message.scale_standard_deviation[i]);
    }
  }
  return line;
}

std::string weld_csv_header() {
  return "stamp,kind,distance,standard_deviation,confidence,amplitude,width,weld,weld_id,"
         "weld_probability,chainage,chainage_standard_deviation";
}

std::string weld_csv_line(const pipescout_msgs::msg::WeldDetection& message) {
  std::string line = stamp_text(message.header.stamp) + ",girth weld";
  append(line, message.distance, message.standard_deviation, message.confidence, message.amplitude,
         message.width);
  if (message.weld < 0) {
    return line + ",,,,,";
  }
  append(line, message.weld, quoted(message.weld_id), message.weld_probability, message.chainage,
         std::sqrt(message.chainage_variance));
  return line;
}

std::string bend_csv_header() {
  return "stamp,distance,standard_deviation,length,angle,angle_standard_deviation,direction,"
         "probability";
}

std::string bend_csv_line(const pipescout_msgs::msg::BendDetection& message) {
  std::string line = stamp_text(message.header.stamp);
  append(line, message.distance, message.standard_deviation, message.length, message.angle,
         message.angle_standard_deviation, message.direction, message.probability);
  return line;
}

std::string position_csv_header() {
  return "stamp,odometer_distance,known,locked,joint,joint_probability,orientation,"
         "distance_into_joint,chainage,standard_deviation,scale,scale_standard_deviation,"
         "hypotheses,double_slip_detected,tally_error_detected,spacing_error";
}

std::string position_csv_line(const pipescout_msgs::msg::PipePosition& message) {
  std::string line = stamp_text(message.header.stamp);
  append(line, message.odometer_distance, message.known, message.locked, message.joint,
         message.joint_probability);
  switch (message.orientation) {
    case PipePosition::ORIENTATION_FORWARD:
      line += ",forward";
      break;
    case PipePosition::ORIENTATION_BACKWARD:
      line += ",backward";
      break;
    default:
      line += ",unknown";
  }
  append(line, message.distance_into_joint, message.chainage, std::sqrt(message.covariance[0]),
         message.scale, std::sqrt(message.covariance[3]), message.hypotheses,
         message.double_slip_detected, message.tally_error_detected, message.spacing_error);
  return line;
}

std::string samples_csv_header(std::size_t channels) {
  std::string header = "stamp";
  for (std::size_t c = 1; c <= channels; ++c) {
    header += ",x" + std::to_string(c) + ",y" + std::to_string(c);
  }
  return header;
}

std::string samples_csv_line(const pipescout_msgs::msg::EddyCurrentSamples& message,
                             std::size_t sample) {
  std::string line =
      format_stamp((from_message(message.header.stamp) +
                    from_seconds(static_cast<double>(sample) * message.sample_interval))
                       .time_since_epoch());
  for (std::size_t c = 0; c < message.channels; ++c) {
    const std::size_t k = sample * message.channels + c;
    line += "," + short_number(message.x[k]) + "," + short_number(message.y[k]);
  }
  return line;
}

}  // namespace pipescout::summary
